#include "abbe/identify/nonlinear.h"

#include <ceres/ceres.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace abbe {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The whole problem as one block.
class Block final : public ceres::CostFunction {
 public:
  explicit Block(const NonlinearProblem& problem) : problem_(problem) {
    set_num_residuals(static_cast<int>(problem.count));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.start.size()));
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const auto m = static_cast<std::size_t>(problem_.start.size()),
               n = static_cast<std::size_t>(problem_.count);
    const std::span<const double> x(parameters[0], m);
    const std::span<double> r(residuals, n);
    const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
    if (!wanted || !problem_.has_jacobian) {
      if (!problem_.residuals(x, r, nullptr)) return false;
      return !wanted || differences(x, jacobians[0]);
    }
    Eigen::MatrixXd jacobian(problem_.count, problem_.start.size());
    if (!problem_.residuals(x, r, &jacobian)) return false;
    Eigen::Map<RowMajor>(jacobians[0], jacobian.rows(), jacobian.cols()) = jacobian;
    return true;
  }

 private:
  /// d r / d x_k = (r(x + h) - r(x - h)) / (2 h), h a cube root of the rounding
  bool differences(std::span<const double> x, double* jacobian) const {
    std::vector<double> at(x.begin(), x.end());
    Eigen::VectorXd above(problem_.count), below(problem_.count);
    const auto n = static_cast<std::size_t>(problem_.count);
    Eigen::Map<RowMajor> out(jacobian, problem_.count, problem_.start.size());
    for (std::size_t k = 0; k < x.size(); ++k) {
      const double h = std::cbrt(std::numeric_limits<double>::epsilon()) * std::max(std::abs(x[k]), 1e-8);
      at[k] = x[k] + h;
      if (!problem_.residuals(at, {above.data(), n}, nullptr)) return false;
      at[k] = x[k] - h;
      if (!problem_.residuals(at, {below.data(), n}, nullptr)) return false;
      at[k] = x[k];
      out.col(static_cast<Eigen::Index>(k)) = (above - below) / (2 * h);
    }
    return true;
  }

  const NonlinearProblem& problem_;
};

}  // namespace

NonlinearSolution minimise(const NonlinearProblem& problem) {
  NonlinearSolution out;
  out.x = problem.start;
  if (problem.start.size() == 0 || problem.count == 0 || !problem.start.allFinite()) return out;
  ceres::Problem::Options owner;
  owner.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  Block block(problem);
  ceres::Problem dense(owner);
  dense.AddResidualBlock(&block, nullptr, out.x.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = problem.most_iterations;
  options.function_tolerance = 1e-16;
  options.gradient_tolerance = 1e-18;
  options.parameter_tolerance = 1e-13;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &dense, &summary);
  out.converged =
      summary.IsSolutionUsable() && summary.termination_type == ceres::CONVERGENCE && out.x.allFinite();
  out.sum_of_squares = 2 * summary.final_cost;
  out.iterations = static_cast<int>(summary.iterations.size());
  if (out.x.allFinite() && std::isfinite(out.sum_of_squares)) return out;
  out.x = problem.start;
  out.sum_of_squares = 0;
  out.converged = false;
  return out;
}

}  // namespace abbe
