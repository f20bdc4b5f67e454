#pragma once

#include <Eigen/Core>

namespace abbe {

/// A linear model of columns that may say nearly the same, such as temperatures near to each other.
struct Ridge {
  Eigen::VectorXd slope;  ///< per unit of each column
  double intercept = 0;
  Eigen::MatrixXd gain;        ///< slope = gain (values - mean)
  Eigen::MatrixXd covariance;  ///< of the slopes for residuals of variance 1; the shrinking is not in it
};

/// On columns brought to mean 0 and (population) standard deviation 1, Z, and centred values y:
///
///   slope = D^-1 (Z^T Z + lambda I)^-1 Z^T y,   D = diag(standard deviation)
///   gain = D^-1 (Z^T Z + lambda I)^-1 Z^T,   covariance = gain gain^T
///
/// shapes   columns n x p, values n; lambda >= 0. A column that does not change gets slope 0.
/// laws     LongleyAtPublishedPenalties, NoPenaltyIsLeastSquares
/// cost     n p^2
/// source   Hoerl, Kennard: Ridge regression (Technometrics 12, 1970)
[[nodiscard]] Ridge fit_ridge(const Eigen::MatrixXd& columns, const Eigen::VectorXd& values, double lambda);

}  // namespace abbe
