#include "abbe/fit/log_freedom.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr double kSame = 1e-6;       ///< columns of one log that say the same
constexpr double kUndecided = 1e-3;  ///< of a column beside the starts, as of every unknown of a fit

/// N of one log.
Eigen::MatrixXd shape_of(const DriftCourse& course, const std::vector<double>& lags) {
  const auto rows = static_cast<Eigen::Index>(course.times.size());
  const Eigen::Map<const Eigen::ArrayXd> t(course.times.data(), rows);
  Eigen::MatrixXd N =
      Eigen::MatrixXd::Ones(rows, 1 + (course.settled ? 0 : static_cast<Eigen::Index>(lags.size())));
  for (Eigen::Index k = 1; k < N.cols(); ++k)
    N.col(k) = (-(t - t[0]) / lags[static_cast<std::size_t>(k - 1)]).exp();
  return N;
}

/// Gram and Schmidt, each column twice, those left out whose rest is rounding.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& N) {
  Eigen::MatrixXd Q(N.rows(), N.cols());
  Eigen::Index rank = 0;
  for (Eigen::Index k = 0; k < N.cols(); ++k) {
    Eigen::VectorXd rest = N.col(k);
    for (int pass = 0; pass < 2; ++pass) rest -= Q.leftCols(rank) * (Q.leftCols(rank).transpose() * rest);
    if (rest.norm() > kSame * N.col(k).norm()) Q.col(rank++) = rest.normalized();
  }
  return Q.leftCols(rank);
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& N) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(kSame);
  return decomposition.compute(N).pseudoInverse();
}

}  // namespace

LogFreedom::LogFreedom(const std::vector<const DriftCourse*>& courses, const std::vector<double>& lags) {
  for (const double lag : lags)
    if (lag > 0 && std::find(lags_.begin(), lags_.end(), lag) == lags_.end()) lags_.push_back(lag);
  Eigen::Index first = 0;
  for (const DriftCourse* course : courses) {
    Eigen::MatrixXd N = shape_of(*course, lags_);
    Eigen::MatrixXd Q = orthonormal(N);
    const Eigen::Index rows = N.rows();
    logs_.push_back({first, std::move(N), std::move(Q)});
    first += rows;
  }
}

Eigen::VectorXd LogFreedom::taken_off(Eigen::VectorXd column) const {
  for (const Log& log : logs_) {
    auto part = column.segment(log.first, log.basis.rows());
    const Eigen::VectorXd shares = log.basis.transpose() * part;
    part -= log.basis * shares;
  }
  return column;
}

Eigen::VectorXd LogFreedom::told(const Eigen::VectorXd& column) const {
  double about_means = 0;  // squares
  for (const Log& log : logs_) {
    const auto part = column.segment(log.first, log.basis.rows());
    about_means += (part.array() - part.mean()).square().sum();
  }
  Eigen::VectorXd rest = taken_off(column);
  if (rest.squaredNorm() <= kUndecided * kUndecided * about_means) rest.setZero();
  return rest;
}

Eigen::Index LogFreedom::rank() const {
  Eigen::Index sum = 0;
  for (const Log& log : logs_) sum += log.basis.cols();
  return sum;
}

Eigen::MatrixXd LogFreedom::coefficients(std::size_t log, const Eigen::MatrixXd& columns) const {
  const Log& one = logs_[log];
  return pseudo_inverse(one.shape) * columns.middleRows(one.first, one.shape.rows());
}

Eigen::MatrixXd LogFreedom::covariance(std::size_t log) const {
  const Eigen::MatrixXd inverse = pseudo_inverse(logs_[log].shape);
  return inverse * inverse.transpose();
}

}  // namespace abbe
