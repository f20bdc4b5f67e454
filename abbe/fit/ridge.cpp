#include "abbe/fit/ridge.h"

#include <Eigen/SVD>
#include <cmath>

namespace abbe {

Ridge fit_ridge(const Eigen::MatrixXd& columns, const Eigen::VectorXd& values, double lambda) {
  if (columns.cols() == 0)
    return {Eigen::VectorXd(0), values.mean(), Eigen::MatrixXd(0, columns.rows()), Eigen::MatrixXd(0, 0)};
  const Eigen::RowVectorXd mean = columns.colwise().mean();
  Eigen::MatrixXd Z = columns.rowwise() - mean;
  Eigen::RowVectorXd inverse = Z.colwise().norm() / std::sqrt(static_cast<double>(columns.rows()));
  for (double& value : inverse) value = value > 0 ? 1 / value : 0;
  Z = Z * inverse.asDiagonal();
  const double middle = values.mean();
  // Z = U S V^T:  (Z^T Z + lambda I)^-1 Z^T = V diag(s / (s^2 + lambda)) U^T
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Z, Eigen::ComputeThinU | Eigen::ComputeThinV);
  Eigen::ArrayXd gain = svd.singularValues().array();
  const double least = gain.size() > 0 ? 1e-13 * gain.maxCoeff() : 0;
  for (double& s : gain) s = s > least ? s / (s * s + lambda) : 0;
  const Eigen::MatrixXd V = inverse.transpose().asDiagonal() * svd.matrixV();
  Ridge out;
  out.gain = V * gain.matrix().asDiagonal() * svd.matrixU().transpose();
  out.slope = out.gain * (values.array() - middle).matrix();
  out.intercept = middle - mean * out.slope;
  out.covariance = out.gain * out.gain.transpose();
  return out;
}

}  // namespace abbe
