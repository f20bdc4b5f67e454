#include "abbe/compensate/plane_turns.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace abbe {
namespace {

constexpr double kWholeTurn = 2 * std::numbers::pi;
constexpr double kProbe = 1e-4;    // rad, of the differences that make the derivative
constexpr double kSolved = 1e-12;  // of (1)
constexpr int kMostSteps = 30;
constexpr double kLargestStep = 0.5;  // rad
constexpr int kStarts = 8;            // per axis
constexpr double kSameTurns = 1e-6;   // rad
constexpr double kFlat = 1e-4;        // an axis that no direction depends on

}  // namespace

PlaneTurns::PlaneTurns(const ControlKinematics& control, const AddressedAxes& axes, const Tool& tool)
    : control_(control), axes_(axes), tool_(tool), back_(control.tip_of_axes(Turns{}, tool).A.inverse()) {}

Vec3 PlaneTurns::tool_direction(const Turns& turns) const {
  return (back_ * control_.pose(Vec3::Zero(), turns, tool_).tool_axis).normalized();
}

std::optional<Turns> PlaneTurns::near(const Vec3& normal, const Turns& from) const {
  Turns turns = from;
  for (int i = 0; i < kMostSteps; ++i) {
    const Vec3 miss = normal - tool_direction(turns);
    if (miss.norm() < kSolved) return turns;
    Mat3 slope = Mat3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (axes_.rotary[k] < 0) continue;
      Turns ahead = turns, behind = turns;
      ahead[k] += kProbe;
      behind[k] -= kProbe;
      slope.col(static_cast<Eigen::Index>(k)) =
          (tool_direction(ahead) - tool_direction(behind)) / (2 * kProbe);
    }
    Eigen::CompleteOrthogonalDecomposition<Mat3> solver;
    solver.setThreshold(kFlat);
    solver.compute(slope);
    Vec3 step = solver.solve(miss);
    if (step.norm() > kLargestStep) step *= kLargestStep / step.norm();
    for (std::size_t k = 0; k < 3; ++k) turns[k] += step[static_cast<Eigen::Index>(k)];
  }
  return std::nullopt;
}

/// The whole turns of each axis: next to `from` where they do not count, else the only ones in the travel.
std::optional<Turns> PlaneTurns::counted(const Turns& turns, const Turns& from) const {
  Turns out = turns;
  for (std::size_t k = 0; k < 3; ++k) {
    if (axes_.rotary[k] < 0) continue;
    const auto axis = static_cast<std::size_t>(axes_.rotary[k]);
    const auto& model = control_.believed().control.axes;
    const bool modulo = axis < model.size() && model[axis].turning != Turning::linear;
    const auto& range = control_.believed().axis(axes_.rotary[k]).range;
    out[k] += kWholeTurn * std::round((from[k] - out[k]) / kWholeTurn);
    if (modulo) continue;
    if (!range) return std::nullopt;
    const double first = std::ceil(((*range)[0] - kSameTurns - out[k]) / kWholeTurn);
    const double last = std::floor(((*range)[1] + kSameTurns - out[k]) / kWholeTurn);
    if (first != last) return std::nullopt;
    out[k] += kWholeTurn * first;
  }
  return out;
}

std::optional<Turns> PlaneTurns::on_side(const Vec3& normal, const Turns& from,
                                         const TiltSolution& side) const {
  const auto chosen = static_cast<std::size_t>(side.axis);
  std::vector<Turns> found;
  for (int i = 0; i < kStarts * kStarts * kStarts; ++i) {
    Turns start{};
    int rest = i;
    bool once = true;
    for (std::size_t k = 0; k < 3; ++k, rest /= kStarts) {
      if (axes_.rotary[k] < 0) {
        once = once && rest % kStarts == 0;
        continue;
      }
      start[k] = kWholeTurn * ((rest % kStarts + 0.3) / kStarts - 0.5);
    }
    const auto solved = once ? near(normal, start) : std::nullopt;
    if (!solved) continue;
    Turns turns = *solved;
    for (double& turn : turns) turn = std::remainder(turn, kWholeTurn);
    if (std::abs(turns[chosen]) < kSameTurns)
      return (normal - tool_direction(from)).norm() < kSameTurns ? near(normal, from) : std::nullopt;
    if (turns[chosen] * side.sign < 0) continue;
    const auto known = std::find_if(found.begin(), found.end(), [&](const Turns& other) {
      double apart = 0;
      for (std::size_t k = 0; k < 3; ++k)
        apart = std::max(apart, std::abs(std::remainder(other[k] - turns[k], kWholeTurn)));
      return apart < kSameTurns;
    });
    if (known == found.end()) found.push_back(turns);
  }
  return found.size() == 1 ? counted(found.front(), from) : std::nullopt;
}

}  // namespace abbe
