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

// One build per instruction set, chosen when the program is loaded. The sanitizers do not go with it.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__clang__)
#define ABBE_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define ABBE_CLONES
#endif

constexpr std::size_t kLanes = 8, kRows = static_cast<std::size_t>(TriangularFactor::kBlock);
static_assert(kRows % kLanes == 0);

/// kLanes numbers side by side: sums run in lanes, so every instruction set adds in one order.
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));

[[gnu::always_inline]] inline void load(Lanes& to, const double* from) { std::memcpy(&to, from, sizeof to); }

[[gnu::always_inline]] inline double sum_of(const Lanes& lanes) {
  double sum = 0;
  for (std::size_t l = 0; l < kLanes; ++l) sum += lanes[l];
  return sum;
}

/// a . b over kRows rows.
[[gnu::always_inline]] inline double dot(const double* a, const double* b) {
  Lanes sum{};
  for (std::size_t i = 0; i < kRows; i += kLanes) {
    Lanes x, y;
    load(x, a + i), load(y, b + i);
    sum += x * y;
  }
  return sum_of(sum);
}

/// Reflections that are applied together, so that the columns behind them are read once for all.
constexpr std::size_t kPanel = 4;

/// H_k = 1 - tau v v^T, v = (1, b_k / v0), of some columns after each other. tau = 0: nothing to fold.
struct Panel {
  std::array<const double*, kPanel> b{};
  std::array<double, kPanel> v0_inverse{}, tau{};
  std::array<std::array<double, kPanel>, kPanel> between{};  ///< b_p . b_q
};

/// The four reflections on one column, whose rows in the triangle begin at r:
///
///     t_p = tau_p (r_p + (b_p . b_j - sum_(q < p) s_q b_p . b_q) / v0_p),   s_p = t_p / v0_p
///     r_p -= t_p,   b_j -= sum_p s_p b_p
[[gnu::always_inline]] inline void reflect(const Panel& panel, double* r, double* bj) {
  Lanes d0{}, d1{}, d2{}, d3{};
  for (std::size_t i = 0; i < kRows; i += kLanes) {
    Lanes y, x;
    load(y, bj + i);
    load(x, panel.b[0] + i), d0 += x * y;
    load(x, panel.b[1] + i), d1 += x * y;
    load(x, panel.b[2] + i), d2 += x * y;
    load(x, panel.b[3] + i), d3 += x * y;
  }
  std::array<double, kPanel> s = {sum_of(d0), sum_of(d1), sum_of(d2), sum_of(d3)};
  for (std::size_t p = 0; p < kPanel; ++p) {
    for (std::size_t q = 0; q < p; ++q) s[p] -= s[q] * panel.between[p][q];
    const double t = panel.tau[p] * (r[p] + s[p] * panel.v0_inverse[p]);
    r[p] -= t;
    s[p] = t * panel.v0_inverse[p];
  }
  for (std::size_t i = 0; i < kRows; i += kLanes) {
    Lanes y, x;
    load(y, bj + i);
    load(x, panel.b[0] + i), y -= s[0] * x;
    load(x, panel.b[1] + i), y -= s[1] * x;
    load(x, panel.b[2] + i), y -= s[2] * x;
    load(x, panel.b[3] + i), y -= s[3] * x;
    std::memcpy(bj + i, &y, sizeof y);
  }
}

/// One reflection p of a panel on one column.
[[gnu::always_inline]] inline void reflect_one(const Panel& panel, std::size_t p, double& r, double* bj) {
  const double t = panel.tau[p] * (r + dot(panel.b[p], bj) * panel.v0_inverse[p]);
  const double s = t * panel.v0_inverse[p];
  r -= t;
  for (std::size_t i = 0; i < kRows; ++i) bj[i] -= s * panel.b[p][i];
}

/// Householder: folds kRows rows (columns one after the other) into the triangle r, both m1 columns. Under
/// the diagonal the triangle is zero, so each reflection touches one row of it:
///
///     v0 = alpha - beta,  beta = -sign(alpha) |(alpha, b_k)|,  tau = -v0 / beta
///
/// r is stored by columns with m1 rows.
ABBE_CLONES void fold_block(double* r, double* block, std::size_t m1) {
  for (std::size_t first = 0; first < m1; first += kPanel) {
    const std::size_t count = std::min(kPanel, m1 - first);
    Panel panel;
    for (std::size_t p = 0; p < count; ++p) {
      const std::size_t k = first + p;
      const double* const bk = panel.b[p] = block + k * kRows;
      if (const double square = dot(bk, bk); square != 0) {
        double& alpha = r[k * m1 + k];
        const double beta = std::sqrt(alpha * alpha + square) * (alpha > 0 ? -1 : 1), v0 = alpha - beta;
        panel.v0_inverse[p] = 1 / v0;
        panel.tau[p] = -v0 / beta;
        alpha = beta;
      }
      for (std::size_t q = 0; q < p; ++q) panel.between[p][q] = dot(bk, panel.b[q]);
      for (std::size_t j = k + 1; j < first + count; ++j)
        reflect_one(panel, p, r[j * m1 + k], block + j * kRows);
    }
    for (std::size_t j = first + kPanel; j < m1; ++j) reflect(panel, r + j * m1 + first, block + j * kRows);
  }
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
