#include "abbe/identify/circle_motion.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr double kAtRest = 1e-9;  // of sin and cos, as in the diagnosis

signed char sign_of(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

/// t' and t'' at sample i from the parabola through its neighbours (least squares).
std::array<double, 2> rates_at(const BallbarRun& run, std::size_t i) {
  const std::size_t n = run.angle.size(), window = 2 * CircleMotion::kHalfWindow + 1;
  const std::size_t first = std::min(i > CircleMotion::kHalfWindow ? i - CircleMotion::kHalfWindow : 0,
                                     n > window ? n - window : 0);
  const std::size_t count = std::min(window, n);
  const double span = run.time[first + count - 1] - run.time[first];
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t k = first; k < first + count; ++k) {
    const double x = (run.time[k] - run.time[i]) / span;
    const Eigen::Vector3d row(1, x, x * x);
    normal += row * row.transpose();
    right += row * (run.angle[k] - run.angle[i]);
  }
  const Eigen::Vector3d c = normal.ldlt().solve(right);
  return {c[1] / span, 2 * c[2] / (span * span)};
}

}  // namespace

TestAxes test_axes(const Machine& machine) {
  TestAxes axes{};
  for (int k = 0; k < 3; ++k) {
    const int i = machine.find_axis(std::string(1, axis_letter(k)));
    axes[static_cast<std::size_t>(k)] = i >= 0 && machine.axis(i).type == AxisType::linear ? i : -1;
  }
  return axes;
}

CircleMotion::CircleMotion(const BallbarTest& test, const BallbarRun& run, const TestAxes& axes)
    : test_(&test), run_(&run), axes_(axes) {
  for (std::size_t i = 0; i < run.angle.size(); ++i) {
    const std::array<double, 2> rates =
        run.time.empty() ? std::array{run.direction * test.feed / test.radius, 0.0} : rates_at(run, i);
    rate_.push_back(rates[0]);
    acceleration_.push_back(rates[1]);
  }
}

double CircleMotion::angle(std::size_t i, double shift) const { return run_->angle[i] + rate_[i] * shift; }

double CircleMotion::bar_angle(std::size_t i, double shift) const {
  if (run_->actual.empty()) return angle(i, shift);
  const Vec3 bar = run_->actual[i] - test_->centre;
  return std::atan2(bar[test_->plane.second], bar[test_->plane.first]) + rate_[i] * shift;
}

AxisState CircleMotion::state(std::size_t i, double shift) const {
  const double t = angle(i, shift), w = rate_[i], R = test_->radius;
  const Vec3 u = radial_direction(test_->plane, t);
  Vec3 along = Vec3::Zero();  // u' = du/dt
  along[test_->plane.first] = -std::sin(t);
  along[test_->plane.second] = std::cos(t);
  Vec3 q = test_->centre + R * u;
  if (!run_->actual.empty()) q = run_->actual[i] + R * w * shift * along;
  const Vec3 v = R * w * along, a = R * (acceleration_[i] * along - w * w * u);
  AxisState state;
  for (int k = 0; k < 3; ++k) {
    const int axis = axes_[static_cast<std::size_t>(k)];
    if (axis < 0) continue;
    const auto at = static_cast<std::size_t>(axis);
    state.q[at] = q[k];
    state.v[at] = v[k];
    state.a[at] = a[k];
    state.approach[at] = std::abs(along[k]) > kAtRest ? sign_of(v[k]) : static_cast<signed char>(0);
  }
  return state;
}

bool CircleMotion::sense_is_sure(std::size_t i, double window) const {
  const double reach = std::abs(rate_[i]) * window + kAtRest;
  return std::abs(std::sin(run_->angle[i])) > reach && std::abs(std::cos(run_->angle[i])) > reach;
}

}  // namespace abbe
