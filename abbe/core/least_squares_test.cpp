#include "abbe/core/least_squares.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "abbe/core/residuals.h"

namespace abbe {
namespace {

constexpr double kRounding = 1e-12;

Eigen::MatrixXd random_matrix(int rows, int columns, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

TriangularFactor factor_of(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  TriangularFactor factor(a.cols());
  factor.add(a, b);
  return factor;
}

TEST(TriangularFactor, FactorKeepsTheGramMatrix) {
  const Eigen::MatrixXd a = random_matrix(1000, 7, 1);
  const Eigen::VectorXd b = random_matrix(1000, 1, 2);
  const Eigen::MatrixXd rc = factor_of(a, b).factor();
  Eigen::MatrixXd ab(1000, 8);
  ab << a, b;
  EXPECT_LT((rc.transpose() * rc - ab.transpose() * ab).norm(), 1e-10);
}

// Reflections go four at a time on two columns at a time: what is left over at either end, columns of zeros
// and columns that say the same.
TEST(TriangularFactor, EveryNumberOfUnknownsKeepsTheGramMatrix) {
  for (int m = 0; m <= 13; ++m) {
    Eigen::MatrixXd ab = random_matrix(300, m + 1, 20 + static_cast<unsigned>(m));
    if (m > 2) ab.col(m / 2).setZero();
    if (m > 4) ab.col(m - 1) = ab.col(0);
    const Eigen::MatrixXd rc = factor_of(ab.leftCols(m), ab.col(m)).factor();
    EXPECT_LT((rc.transpose() * rc - ab.transpose() * ab).norm(), 1e-10) << m;
    EXPECT_TRUE(rc.isUpperTriangular(0)) << m;
  }
}

TEST(TriangularFactor, FactorOfBlocksEqualsFactorOfTheWhole) {
  const Eigen::MatrixXd a = random_matrix(777, 5, 3);
  const Eigen::VectorXd b = random_matrix(777, 1, 4);
  TriangularFactor one_by_one(5), first(5), second(5);
  for (int i = 0; i < 777; ++i) {
    const Eigen::VectorXd row = a.row(i);
    one_by_one.add({row.data(), 5}, b[i]);
  }
  first.add(a.topRows(300), b.head(300));
  second.add(a.bottomRows(477), b.tail(477));
  first.add(second);
  const LeastSquaresSolution whole = solve(factor_of(a, b), {});
  for (const TriangularFactor* factor : {&one_by_one, &first}) {
    const LeastSquaresSolution x = solve(*factor, {});
    EXPECT_LT((x.x - whole.x).norm(), kRounding);
    EXPECT_EQ(x.rows, 777);
    EXPECT_NEAR(x.sum_of_squares, (a * x.x - b).squaredNorm(), 1e-9);
  }
}

TEST(LeastSquares, EqualsPseudoInverse) {
  Eigen::MatrixXd a = random_matrix(60, 4, 5) * random_matrix(4, 9, 6);  // rank 4
  const Eigen::VectorXd b = random_matrix(60, 1, 7);
  const LeastSquaresSolution x = solve(factor_of(a, b), {1e-9, false});
  ASSERT_TRUE(x.ok());
  EXPECT_EQ(x.rank, 4);
  EXPECT_LT((x.x - a.completeOrthogonalDecomposition().pseudoInverse() * b).norm(), 1e-10);
  EXPECT_LT((a * x.null_space).norm(), 1e-10);
  EXPECT_EQ(x.null_space.cols(), 5);
  EXPECT_NEAR(x.sum_of_squares, (a * x.x - b).squaredNorm(), 1e-10);
}

// The integer matrix of rank 2 whose pseudo-inverse is known in fractions: x = (119/715, 238/715, 67/715,
// 186/715).
TEST(LeastSquares, FullRankFactorisationOfAnIntegerMatrix) {
  Eigen::MatrixXd a(6, 4);
  a << 1, 2, 3, 4, 2, 4, 1, 3, 3, 6, 4, 7, 1, 2, -2, -1, 0, 0, 5, 5, 4, 8, 2, 6;
  Eigen::VectorXd b(6);
  b << 1, 2, 3, 4, 5, 6;
  const LeastSquaresSolution x = solve(factor_of(a, b), {1e-9, false});
  EXPECT_EQ(x.rank, 2);
  const Eigen::Vector4d wanted(0.16643356643356644, 0.3328671328671329, 0.0937062937062937,
                               0.2601398601398601);
  EXPECT_LT((x.x - wanted).norm(), kRounding);
}

TEST(LeastSquares, NullSpaceIsInvisible) {
  Eigen::MatrixXd a = random_matrix(50, 3, 8);
  Eigen::MatrixXd wide(50, 4);
  wide << a, 100 * a.col(1);  // b and f only as b + 100 f
  const LeastSquaresSolution x = solve(factor_of(wide, random_matrix(50, 1, 9)), {});
  EXPECT_EQ(x.rank, 3);
  EXPECT_NEAR(x.determined[0], 1, kRounding);
  EXPECT_NEAR(x.determined[2], 1, kRounding);
  EXPECT_LT(x.determined[1], 0.6);
  EXPECT_NEAR(x.null_space(1, 0) / x.null_space(3, 0), -100, 1e-8);
}

TEST(LeastSquares, ScalingMakesUnitsIrrelevant) {
  Eigen::MatrixXd a = random_matrix(50, 3, 10);
  const Eigen::VectorXd b = random_matrix(50, 1, 11);
  const LeastSquaresSolution plain = solve(factor_of(a, b), {});
  a.col(1) *= 1e-12;
  const LeastSquaresSolution tiny = solve(factor_of(a, b), {});
  EXPECT_EQ(tiny.rank, 3);
  EXPECT_NEAR(tiny.x[1] * 1e-12, plain.x[1], kRounding);
  EXPECT_NEAR(std::sqrt(tiny.cofactor(1, 1)) * 1e-12, std::sqrt(plain.cofactor(1, 1)), kRounding);
}

TEST(LeastSquares, NothingComesOutOfNothing) {
  EXPECT_EQ(solve(TriangularFactor(3), {}).status, LeastSquaresSolution::Status::no_rows);
  TriangularFactor bad(1);
  bad.add(std::vector{std::numeric_limits<double>::quiet_NaN()}, 1.0);
  EXPECT_EQ(solve(bad, {}).status, LeastSquaresSolution::Status::not_finite);
  TriangularFactor block(1);
  block.add(Eigen::MatrixXd::Constant(3, 1, std::numeric_limits<double>::infinity()),
            Eigen::VectorXd::Ones(3));
  EXPECT_EQ(solve(block, {}).status, LeastSquaresSolution::Status::not_finite);
  EXPECT_EQ(solve(TriangularFactor(0), {}).x.size(), 0);
  TriangularFactor zero(2);
  zero.add(Eigen::MatrixXd::Zero(5, 2), Eigen::VectorXd::Ones(5));
  const LeastSquaresSolution nothing = solve(zero, {});
  EXPECT_EQ(nothing.rank, 0);
  EXPECT_EQ(nothing.x.norm(), 0);
  EXPECT_NEAR(nothing.sum_of_squares, 5, kRounding);
}

/// A CSV file of numbers with a header row; cells that are no numbers are skipped.
std::vector<std::vector<double>> numbers_in(const std::string& path) {
  std::vector<std::vector<double>> rows;
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) {
      char* end = nullptr;
      const double value = std::strtod(cell.c_str(), &end);
      if (end != cell.c_str() && *end == '\0') rows.back().push_back(value);
    }
  }
  return rows;
}

// National Institute of Standards and Technology, Statistical Reference Datasets, linear regression.
TEST(LeastSquares, NistCertifiedDigits) {
  const std::string folder = ABBE_SOURCE_DIR "/../shared/data/numerics/nist-linear/";
  if (!std::ifstream(folder + "longley.csv")) GTEST_SKIP() << "no NIST data sets beside the sources";
  const auto certified = numbers_in(folder + "longley_certified_full.csv");
  const auto data = numbers_in(folder + "longley.csv");
  ASSERT_EQ(data.size(), 16U);
  TriangularFactor factor(7);
  for (const std::vector<double>& row : data) {
    ASSERT_EQ(row.size(), 7U);
    std::vector<double> design = {1};
    design.insert(design.end(), row.begin() + 1, row.end());
    factor.add(design, row[0]);
  }
  const LeastSquaresSolution x = solve(factor, {1e-12, true});
  ASSERT_TRUE(x.ok());
  EXPECT_EQ(x.rank, 7);
  constexpr double kNineDigits = 1e-9;  // the data lose seven of sixteen digits by their condition
  for (std::size_t i = 0; i < 7; ++i) {
    const auto& row = certified[i];
    const auto k = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(x.x[k] / row[row.size() - 2], 1, kNineDigits) << i;
    EXPECT_NEAR(std::sqrt(x.cofactor(k, k) * x.variance()) / row.back(), 1, kNineDigits) << i;
  }
}

TEST(Residuals, WhiteNoiseIsWhite) {
  std::mt19937 random(12);
  std::normal_distribution<double> normal(0, 2);
  std::vector<double> noise(20000);
  for (double& x : noise) x = normal(random);
  const ResidualSummary summary = summary_of_residuals({noise});
  EXPECT_TRUE(summary.white);
  EXPECT_NEAR(summary.rms, 2, 0.05);
  EXPECT_EQ(summary.count, 20000U);
}

TEST(Residuals, SineIsNotWhite) {
  std::vector<double> sine(3000);
  for (std::size_t i = 0; i < sine.size(); ++i) sine[i] = std::sin(0.05 * static_cast<double>(i));
  EXPECT_FALSE(summary_of_residuals({sine}).white);
}

TEST(Residuals, TauOfAnAutoregressiveProcess) {
  std::mt19937 random(13);
  std::normal_distribution<double> normal;
  constexpr double kMemory = 0.8;  // x_i = 0.8 x_{i-1} + e_i has tau = (1 + 0.8) / (1 - 0.8)
  std::vector<double> x(200000, 0.0);
  for (std::size_t i = 1; i < x.size(); ++i) x[i] = kMemory * x[i - 1] + normal(random);
  const ResidualSummary summary = summary_of_residuals({x});
  EXPECT_NEAR(summary.tau, 9, 0.9);
  EXPECT_NEAR(summary.lag_one, kMemory, 0.01);
  EXPECT_FALSE(summary.white);
}

TEST(Residuals, NothingIsNothing) {
  EXPECT_EQ(summary_of_residuals({}).count, 0U);
  EXPECT_TRUE(summary_of_residuals({}).white);
}

}  // namespace
}  // namespace abbe
