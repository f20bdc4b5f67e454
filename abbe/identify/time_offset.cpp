#include "abbe/identify/time_offset.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <cmath>
#include <span>

#include "abbe/identify/nonlinear.h"

namespace abbe {
namespace {

constexpr double kStep = 1e-5;  // s, of the difference along the path
constexpr int kMostIterations = 30;

struct Sample {
  std::size_t test, run, index;
};

std::vector<Sample> samples_of(const JointDesign& design, double window) {
  std::vector<Sample> out;
  for (std::size_t t = 0; t < design.tests().size(); ++t)
    for (std::size_t r = 0; r < design.tests()[t].runs.size(); ++r)
      for (std::size_t i = 0; i < design.motion(t, r).size(); ++i)
        if (design.motion(t, r).sense_is_sure(i, window)) out.push_back({t, r, i});
  return out;
}

/// Unknowns x = (y, clocks): coefficients root * y, then one clock per run.
class Clocked {
 public:
  Clocked(const JointDesign& design, const LeastSquaresSolution& fit, const RunClocks& clocks, double prior,
          double window, const std::function<double(std::size_t)>& noise)
      : design_(design),
        root_(fit.root),
        clocks_(clocks),
        prior_(prior),
        noise_(noise),
        samples_(samples_of(design, window)),
        row_(design.unknowns()),
        later_(row_),
        earlier_(row_) {}

  [[nodiscard]] Eigen::Index linear() const { return root_.cols(); }
  [[nodiscard]] Eigen::Index unknowns() const {
    return linear() + static_cast<Eigen::Index>(clocks_.count());
  }
  [[nodiscard]] Eigen::Index residual_count() const {
    return static_cast<Eigen::Index>(samples_.size() + clocks_.count());
  }

  bool evaluate(std::span<const double> x, std::span<double> residuals, Eigen::MatrixXd* jacobian) {
    const auto y = Eigen::Map<const Eigen::VectorXd>(x.data(), linear());
    const Eigen::VectorXd coefficients = root_ * y;
    if (jacobian != nullptr) jacobian->setZero();
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      const Sample& s = samples_[k];
      const std::size_t clock = static_cast<std::size_t>(linear()) + clocks_.index(s.test, s.run);
      const double weight = 1 / noise_(s.test), shift = x[clock];
      design_.row(s.test, s.run, s.index, shift, row_);
      const Eigen::Map<const Eigen::VectorXd> row(row_.data(), root_.rows());
      const double deviation =
          design_.tests()[s.test].runs[s.run].deviation[s.index] - design_.servo_part(s.test, s.run, s.index);
      residuals[k] = weight * (row.dot(coefficients) - deviation);
      if (jacobian == nullptr) continue;
      const auto at = static_cast<Eigen::Index>(k);
      jacobian->row(at).head(linear()) = weight * (root_.transpose() * row).transpose();
      (*jacobian)(at, static_cast<Eigen::Index>(clock)) = weight * slope(s, shift, coefficients);
    }
    for (std::size_t k = 0; k < clocks_.count(); ++k) {
      const std::size_t at = samples_.size() + k, clock = static_cast<std::size_t>(linear()) + k;
      residuals[at] = x[clock] / prior_;
      if (jacobian != nullptr)
        (*jacobian)(static_cast<Eigen::Index>(at), static_cast<Eigen::Index>(clock)) = 1 / prior_;
    }
    return true;
  }

 private:
  /// d(row . coefficients) / d shift
  double slope(const Sample& s, double shift, const Eigen::VectorXd& coefficients) {
    design_.row(s.test, s.run, s.index, shift + kStep, later_);
    design_.row(s.test, s.run, s.index, shift - kStep, earlier_);
    const auto n = static_cast<Eigen::Index>(later_.size());
    return (Eigen::Map<const Eigen::VectorXd>(later_.data(), n) -
            Eigen::Map<const Eigen::VectorXd>(earlier_.data(), n))
               .dot(coefficients) /
           (2 * kStep);
  }

  const JointDesign& design_;
  const Eigen::MatrixXd& root_;
  const RunClocks& clocks_;
  double prior_;
  const std::function<double(std::size_t)>& noise_;
  std::vector<Sample> samples_;
  std::vector<double> row_, later_, earlier_;
};

void take(Identification& out, RunClocks& clocks, Clocked& model, const LeastSquaresSolution& fit,
          const std::vector<double>& x) {
  std::vector<double> residuals(static_cast<std::size_t>(model.residual_count()));
  Eigen::MatrixXd jacobian(model.residual_count(), model.unknowns());
  if (!model.evaluate(x, residuals, &jacobian)) return;
  TriangularFactor factor(model.unknowns());
  factor.add(jacobian, Eigen::Map<const Eigen::VectorXd>(residuals.data(), model.residual_count()));
  const LeastSquaresSolution local = solve(factor, {1e-9, true});
  const Eigen::Index m = fit.root.rows(), k = model.linear(), c = static_cast<Eigen::Index>(clocks.count());
  // From (y, clocks) to (coefficients, clocks).
  Eigen::MatrixXd back = Eigen::MatrixXd::Zero(m + c, k + c);
  back.topLeftCorner(m, k) = fit.root;
  back.bottomRightCorner(c, c).setIdentity();
  out.values = back * Eigen::Map<const Eigen::VectorXd>(x.data(), k + c);
  out.covariance = back * local.cofactor * back.transpose();
  out.null_space.conservativeResize(m + c, Eigen::NoChange);
  out.null_space.bottomRows(c).setZero();
  out.column_length.conservativeResize(m + c);
  out.column_length.tail(c).setOnes();
}

}  // namespace

RunClocks::RunClocks(const std::vector<BallbarTest>& tests) {
  for (const BallbarTest& test : tests) {
    first_.push_back(offset_.size());
    offset_.resize(offset_.size() + test.runs.size(), 0.0);
  }
}

void fit_time_offsets(Identification& out, RunClocks& clocks, const JointDesign& design,
                      const LeastSquaresSolution& fit, const IdentifyOptions& options,
                      const std::function<double(std::size_t)>& noise) {
  Clocked model(design, fit, clocks, options.time_offset, options.reversal_window, noise);
  NonlinearProblem problem;
  problem.residuals = [&](std::span<const double> x, std::span<double> r, Eigen::MatrixXd* j) {
    return model.evaluate(x, r, j);
  };
  problem.count = model.residual_count();
  problem.has_jacobian = true;
  problem.most_iterations = kMostIterations;
  problem.start = Eigen::VectorXd::Zero(model.unknowns());
  // root y = x has an exact solution; in scaled unknowns its columns are orthogonal.
  const Eigen::MatrixXd scaled = fit.column_length.asDiagonal() * fit.root;
  problem.start.head(model.linear()) =
      scaled.colPivHouseholderQr().solve(fit.column_length.cwiseProduct(fit.x));
  const NonlinearSolution solved = minimise(problem);
  if (!solved.converged) {
    out.doubts.push_back("the clocks of the runs could not be found: the iteration did not settle");
    return;
  }
  const std::vector<double> x(solved.x.data(), solved.x.data() + solved.x.size());
  take(out, clocks, model, fit, x);
  for (std::size_t t = 0; t < design.tests().size(); ++t) {
    for (std::size_t r = 0; r < design.tests()[t].runs.size(); ++r) {
      clocks.at(t, r) = x[static_cast<std::size_t>(model.linear()) + clocks.index(t, r)];
      out.names.push_back(fmt::format("clock of {} run {}", design.tests()[t].file, r + 1));
    }
  }
}

}  // namespace abbe
