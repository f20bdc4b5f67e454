#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>

namespace abbe {

/// Residuals of a nonlinear least-squares problem at x: fills `residuals`, and `jacobian` (residuals x
/// parameters) where it is not null. False: x is outside what the model allows.
using ResidualFunction =
    std::function<bool(std::span<const double> x, std::span<double> residuals, Eigen::MatrixXd* jacobian)>;

struct NonlinearProblem {
  ResidualFunction residuals;
  Eigen::Index count = 0;  ///< of residuals
  Eigen::VectorXd start;
  bool has_jacobian = false;  ///< false: central differences
  int most_iterations = 500;
};

struct NonlinearSolution {
  bool converged = false;
  Eigen::VectorXd x;
  double sum_of_squares = 0;
  int iterations = 0;
};

/// Least sum of squares by a trust region (Levenberg-Marquardt) with dense QR steps.
///
/// errors   converged = false; x is then the best point found
/// laws     NistCertifiedParameters
/// source   Ceres Solver; docs/decisions/0015-ceres.md
[[nodiscard]] NonlinearSolution minimise(const NonlinearProblem& problem);

}  // namespace abbe
