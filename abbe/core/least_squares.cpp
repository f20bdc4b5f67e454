#include "abbe/core/least_squares.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace abbe {

namespace {

constexpr std::size_t kLanes = 8, kRows = static_cast<std::size_t>(TriangularFactor::kBlock);
static_assert(kRows % kLanes == 0);

// One build per instruction set, chosen by what the processor has. Not by target_clones: vectors would be cut
// to the smallest set before the clones are made. The sanitizers do not go with it.
namespace baseline {
#include "abbe/core/least_squares_fold.h"
}
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__clang__)
#define ABBE_WIDER_VECTORS
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
#include "abbe/core/least_squares_fold.h"
}
#pragma GCC target("avx512f")
namespace avx512 {
#include "abbe/core/least_squares_fold.h"
}
#pragma GCC pop_options
#endif

using Fold = void (*)(double* r, double* block, std::size_t m1);

Fold widest_fold() {
#ifdef ABBE_WIDER_VECTORS
  if (__builtin_cpu_supports("avx512f")) return avx512::fold_block;
  if (__builtin_cpu_supports("avx2")) return avx2::fold_block;
#endif
  return baseline::fold_block;
}

}  // namespace

TriangularFactor::TriangularFactor(Eigen::Index unknowns)
    : m_(unknowns),
      factor_(Eigen::MatrixXd::Zero(unknowns + 1, unknowns + 1)),
      block_(Eigen::MatrixXd::Zero(kBlock, unknowns + 1)) {}

void TriangularFactor::add(std::span<const double> row, double value) {
  assert(static_cast<Eigen::Index>(row.size()) == m_);
  bool finite = std::isfinite(value);
  for (const double x : row) finite = finite && std::isfinite(x);
  if (!finite) {
    finite_ = false;
    return;
  }
  block_.row(used_).head(m_) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), m_);
  block_(used_, m_) = value;
  ++rows_;
  if (++used_ == kBlock) fold();
}

void TriangularFactor::add(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                           const Eigen::Ref<const Eigen::VectorXd>& values) {
  assert(rows.cols() == m_ && rows.rows() == values.size());
  for (Eigen::Index done = 0; done < rows.rows();) {
    const Eigen::Index k = std::min(rows.rows() - done, kBlock - used_);
    block_.block(used_, 0, k, m_) = rows.middleRows(done, k);
    block_.col(m_).segment(used_, k) = values.segment(done, k);
    // 0 x is 0 for every finite x and for no other.
    if (!((block_.middleRows(used_, k) * 0.0).array() == 0.0).all()) {
      finite_ = false;
      block_.middleRows(used_, k).setZero();
    }
    used_ += k;
    rows_ += k;
    done += k;
    if (used_ == kBlock) fold();
  }
}

void TriangularFactor::add(const TriangularFactor& other) {
  assert(other.m_ == m_);
  const Eigen::MatrixXd rc = other.factor();
  const Eigen::Index rows = rows_ + other.rows_;
  add(rc.leftCols(m_), rc.col(m_));
  rows_ = rows;
  finite_ = finite_ && other.finite_;
}

void TriangularFactor::fold() {
  if (used_ == 0) return;
  static const Fold fold_block = widest_fold();
  fold_block(factor_.data(), block_.data(), static_cast<std::size_t>(m_) + 1);
  block_.setZero();
  used_ = 0;
}

Eigen::MatrixXd TriangularFactor::factor() const {
  if (used_ == 0) return factor_;
  TriangularFactor folded = *this;
  folded.fold();
  return folded.factor_;
}

namespace {

Eigen::VectorXd lengths_of_columns(const Eigen::MatrixXd& r, bool scaled) {
  Eigen::VectorXd length = Eigen::VectorXd::Ones(r.cols());
  if (!scaled) return length;
  for (Eigen::Index i = 0; i < r.cols(); ++i) {
    const double l = r.col(i).stableNorm();
    if (l > 0 && std::isfinite(l)) length[i] = l;
  }
  return length;
}

}  // namespace

LeastSquaresSolution solve(const TriangularFactor& factor, const LeastSquaresOptions& options) {
  using Status = LeastSquaresSolution::Status;
  const Eigen::Index m = factor.unknowns();
  LeastSquaresSolution out;
  out.rows = factor.rows();
  out.x = out.determined = out.singular_values = Eigen::VectorXd::Zero(m);
  out.cofactor = Eigen::MatrixXd::Zero(m, m);
  out.column_length = Eigen::VectorXd::Ones(m);
  out.null_space = Eigen::MatrixXd::Identity(m, m);
  out.root = Eigen::MatrixXd::Zero(m, 0);
  const Eigen::MatrixXd rc = factor.factor();
  if (!factor.is_finite() || !rc.allFinite()) {
    out.status = Status::not_finite;
    return out;
  }
  if (out.rows == 0) {
    out.status = Status::no_rows;
    return out;
  }
  const Eigen::VectorXd c = rc.col(m).head(m);
  const double rho = rc(m, m);
  if (m == 0) {
    out.sum_of_squares = rho * rho;
    return out;
  }
  const Eigen::MatrixXd r = rc.topLeftCorner(m, m);
  out.column_length = lengths_of_columns(r, options.scale_columns);
  const Eigen::VectorXd d = out.column_length.cwiseInverse();

  // A D = Q U S V^T
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(r * d.asDiagonal(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  out.singular_values = svd.singularValues();
  const double least = options.tolerance * out.singular_values[0];
  while (out.rank < m && out.singular_values[out.rank] > least && out.singular_values[out.rank] > 0)
    ++out.rank;
  const Eigen::Index k = out.rank;
  const Eigen::VectorXd inverse = out.singular_values.head(k).cwiseInverse();
  out.root = d.asDiagonal() * svd.matrixV().leftCols(k) * inverse.asDiagonal();

  // x = D V_1 S_1^-1 U_1^T c,   cofactor = (D V_1 S_1^-1)(D V_1 S_1^-1)^T
  out.x = out.root * (svd.matrixU().leftCols(k).transpose() * c);
  out.cofactor = out.root * out.root.transpose();
  out.null_space = d.asDiagonal() * svd.matrixV().rightCols(m - k);
  out.determined = svd.matrixV().leftCols(k).rowwise().squaredNorm();
  out.sum_of_squares = rho * rho + (r * out.x - c).squaredNorm();
  if (!out.x.allFinite() || !out.cofactor.allFinite() || !std::isfinite(out.sum_of_squares)) {
    out.x.setZero();
    out.cofactor.setZero();
    out.sum_of_squares = 0;
    out.status = Status::not_finite;
  }
  return out;
}

}  // namespace abbe
