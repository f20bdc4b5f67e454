#include "abbe/core/least_squares.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace abbe {

TriangularFactor::TriangularFactor(Eigen::Index unknowns)
    : m_(unknowns), used_(unknowns + 1), work_(Eigen::MatrixXd::Zero(unknowns + 1 + kBlock, unknowns + 1)) {}

void TriangularFactor::add(std::span<const double> row, double value) {
  assert(static_cast<Eigen::Index>(row.size()) == m_);
  bool finite = std::isfinite(value);
  for (const double x : row) finite = finite && std::isfinite(x);
  if (!finite) {
    finite_ = false;
    return;
  }
  if (used_ == work_.rows()) fold();
  work_.row(used_).head(m_) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), m_);
  work_(used_, m_) = value;
  ++used_;
  ++rows_;
}

void TriangularFactor::add(const Eigen::Ref<const Eigen::MatrixXd>& rows,
                           const Eigen::Ref<const Eigen::VectorXd>& values) {
  assert(rows.cols() == m_ && rows.rows() == values.size());
  Eigen::Index done = 0;
  while (done < rows.rows()) {
    if (used_ == work_.rows()) fold();
    const Eigen::Index k = std::min(rows.rows() - done, work_.rows() - used_);
    work_.block(used_, 0, k, m_) = rows.middleRows(done, k);
    work_.col(m_).segment(used_, k) = values.segment(done, k);
    // 0 x is 0 for every finite x and for no other.
    if (!((work_.middleRows(used_, k) * 0.0).array() == 0.0).all()) {
      finite_ = false;
      work_.middleRows(used_, k).setZero();
    }
    used_ += k;
    rows_ += k;
    done += k;
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
  Eigen::Ref<Eigen::MatrixXd> used = work_.topRows(used_);
  const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(used);  // in place
  work_.topRows(m_ + 1).triangularView<Eigen::StrictlyLower>().setZero();
  used_ = m_ + 1;
}

Eigen::MatrixXd TriangularFactor::factor() const {
  TriangularFactor folded = *this;
  folded.fold();
  return folded.work_.topRows(m_ + 1);
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
