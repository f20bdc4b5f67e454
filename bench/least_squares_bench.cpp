// Least squares of many rows and 16 unknowns of rank 14, with the solution of least norm: folded row block by
// row block (abbe/core/least_squares.h) beside Eigen's complete orthogonal decomposition of the whole matrix.
//   build/release/bench/least_squares_bench

#include <benchmark/benchmark.h>

#include <Eigen/QR>
#include <random>

#include "abbe/core/least_squares.h"

namespace {

constexpr Eigen::Index kColumns = 16, kRank = 14;

struct Problem {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;
};

const Problem& problem(Eigen::Index rows) {
  static Problem made;
  if (made.a.rows() == rows) return made;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  made.a.resize(rows, kColumns);
  for (Eigen::Index k = 0; k < kRank; ++k)
    for (Eigen::Index i = 0; i < rows; ++i) made.a(i, k) = normal(random);
  made.a.col(14) = 100 * made.a.col(0);
  made.a.col(15) = made.a.col(1) - made.a.col(2);
  made.b = made.a * Eigen::VectorXd::LinSpaced(kColumns, 1, 2);
  return made;
}

void fold_rows(benchmark::State& state) {
  const Problem& p = problem(state.range(0));
  Eigen::Index rank = 0;
  for (auto _ : state) {
    abbe::TriangularFactor factor(kColumns);
    factor.add(p.a, p.b);
    const auto solution = abbe::solve(factor, {1e-9, false});
    rank = solution.rank;
    benchmark::DoNotOptimize(solution.x.data());
  }
  if (rank != kRank) state.SkipWithError("wrong rank");
}

void complete_orthogonal_decomposition(benchmark::State& state) {
  const Problem& p = problem(state.range(0));
  Eigen::Index rank = 0;
  for (auto _ : state) {
    const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> cod(p.a);
    const Eigen::VectorXd x = cod.solve(p.b);
    rank = cod.rank();
    benchmark::DoNotOptimize(x.data());
  }
  if (rank != kRank) state.SkipWithError("wrong rank");
}

BENCHMARK(fold_rows)->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);
BENCHMARK(complete_orthogonal_decomposition)->Arg(100'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond);

}  // namespace
