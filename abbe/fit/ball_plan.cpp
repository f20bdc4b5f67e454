#include "abbe/fit/ball_plan.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <optional>
#include <utility>

#include "abbe/chain/plan.h"
#include "abbe/chain/predict.h"

namespace abbe {
namespace {

using AxisPositions = std::array<double, kMaxAxes>;

std::vector<int> linear_axes(const Machine& machine) {
  std::vector<int> out;
  for (int i = 0; i < machine.axis_count(); ++i)
    if (machine.axis(i).type == AxisType::linear) out.push_back(i);
  return out;
}

/// All combinations of the angles, the last axis fastest.
std::vector<AxisPositions> turned_poses(const BallPlan& plan) {
  std::vector<AxisPositions> poses = {{}};
  for (std::size_t k = 0; k < kMaxAxes; ++k) {
    if (plan.angles[k].empty()) continue;
    std::vector<AxisPositions> finer;
    for (const AxisPositions& pose : poses)
      for (const double angle : plan.angles[k]) {
        finer.push_back(pose);
        finer.back()[k] = angle;
      }
    poses = std::move(finer);
  }
  return poses;
}

/// q of the linear axes: tip(0) + J q = place, J by unit steps.
std::optional<AxisPositions> touching(const Plan& ideal, const Tool& tool, const std::vector<int>& axes,
                                      const Vec3& place, AxisPositions pose) {
  Query query;
  query.tool = tool;
  query.q = pose;
  const Vec3 home = nominal_tip(ideal, query);
  Mat3 J;
  for (Eigen::Index k = 0; k < 3; ++k) {
    query.q = pose;
    query.q[static_cast<std::size_t>(axes[static_cast<std::size_t>(k)])] = 1;
    J.col(k) = nominal_tip(ideal, query) - home;
  }
  const Eigen::FullPivLU<Mat3> lu(J);
  if (!lu.isInvertible()) return std::nullopt;
  const Vec3 q = lu.solve(place - home);
  for (Eigen::Index k = 0; k < 3; ++k)
    pose[static_cast<std::size_t>(axes[static_cast<std::size_t>(k)])] = q[k];
  return pose;
}

std::optional<std::string> beyond_travel(const Machine& machine, const AxisPositions& pose) {
  constexpr double kSlack = 1e-9;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const auto& range = machine.axis(i).range;
    const double q = pose[static_cast<std::size_t>(i)];
    if (range && (q < (*range)[0] - kSlack || q > (*range)[1] + kSlack))
      return fmt::format("{} would have to go to {:.6g}", machine.axis(i).name, q / machine.axis_unit(i));
  }
  return std::nullopt;
}

}  // namespace

std::variant<FitPoints, std::string> plan_balls(const Machine& machine, const BallPlan& plan) {
  const std::vector<int> axes = linear_axes(machine);
  Machine without_errors = machine;
  without_errors.errors.clear();
  const auto ideal = std::get<Plan>(make_plan(without_errors, {}, ErrorModel::first_order));
  FitPoints points;
  points.planned = true;
  for (std::size_t b = 0; b < plan.places.size(); ++b)
    for (const AxisPositions& turned : turned_poses(plan)) {
      const auto pose =
          axes.size() == 3 ? touching(ideal, tool_of(machine), axes, plan.places[b], turned) : std::nullopt;
      if (!pose) return std::string("the linear axes do not span space, or are not three");
      if (auto why = beyond_travel(machine, *pose)) return std::move(*why);
      points.poses.push_back(*pose);
      points.ball.push_back(static_cast<int>(b) + 1);
      points.readings.push_back(Vec3::Zero());
    }
  return points;
}

}  // namespace abbe
