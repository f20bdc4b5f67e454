#include "abbe/gear/cutting_motion.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>

#include "abbe/chain/solve_path.h"

namespace abbe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// The chain alone: no errors, every axis free, and no travels unless they are asked for.
Plan ideal_plan(const Machine& machine, bool with_travels) {
  Machine ideal = machine;
  ideal.errors.clear();
  for (Body& body : ideal.bodies) {
    body.correctable = true;
    if (!with_travels) body.range.reset();
  }
  return std::get<Plan>(make_plan(ideal, {}));
}

PathOptions path_options(const Plan& plan) {
  PathOptions options;
  options.ideal = true;
  options.free = free_axes(plan.machine(), 0).value_or(free_axes(plan.machine(), ~AxisSet{0}).value_or(0));
  return options;
}

InverseResult first_pose(const Plan& plan, const TipAndAxis& pose, const AxisCommands& start) {
  PathSolver path(path_options(plan), start);
  return path.pose(plan, tool_of(plan.machine()), pose.position, pose.tool_axis);
}

/// How far the rotary axes are from the start.
double turning(const Machine& machine, const AxisCommands& q, const AxisCommands& start) {
  double sum = 0;
  for (int i = 0; i < machine.axis_count(); ++i)
    if (machine.axis(i).type == AxisType::rotary)
      sum += std::abs(q[static_cast<std::size_t>(i)] - start[static_cast<std::size_t>(i)]);
  return sum;
}

/// The end of the wheel axis at which the spindle is; nullopt: neither can be held.
std::optional<double> axis_sign_of(const Plan& plan, const GearJob& job, const WheelInGap& wheel,
                                   double height, const AxisCommands& start) {
  std::optional<double> best;
  double least = 0;
  for (const double sign : {-1.0, 1.0}) {
    const InverseResult found = first_pose(plan, wheel_pose(job, wheel, 0, height, sign), start);
    if (found.status == Status::failed) continue;
    const double by = turning(plan.machine(), found.q, start);
    // Half a turn of C makes the two ends alike on many machines: the first one wins unless it needs more.
    if (best && by > least - 1e-6) continue;
    best = sign;
    least = by;
  }
  return best;
}

CuttingProblem missing_axes(const Machine& machine, const WheelInGap& wheel) {
  const double swivel = std::atan2(-wheel.axis.z(), wheel.axis.y());
  return {CuttingProblem::Trouble::axes,
          fmt::format(
              "the chain {} cannot hold the wheel in a gap: centre distance {:.4f} mm, wheel axis swivelled "
              "by {:.4f} deg",
              machine.chain, wheel.centre_distance, swivel / deg)};
}

}  // namespace

Mat3 gap_axes(const GearJob& job, std::size_t gap, double height) {
  const double angle = job.cutting.first_gap + kTurn * static_cast<double>(gap) / job.gear.spec.teeth +
                       job.gear.turn_per_mm * height;
  return Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
}

TipAndAxis wheel_pose(const GearJob& job, const WheelInGap& wheel, std::size_t gap, double height,
                      double axis_sign) {
  const Mat3 R = gap_axes(job, gap, height);
  const double distance = wheel.centre_distance + crowning_infeed(job.gear, wheel, height);
  return {R * Vec3(distance, 0, 0) + Vec3(0, 0, job.cutting.middle + height), axis_sign * (R * wheel.axis)};
}

Stroke stroke_of(const GearJob& job, const WheelInGap& wheel) {
  const double half = job.gear.spec.face_width / 2 + wheel.reach + job.cutting.overrun;
  return {-half, half};
}

Approach approach_of(const GearJob& job) {
  const double radius = job.wheel.diameter / 2, depth = job.gear.tip_radius - job.gear.root_radius;
  return {job.cutting.clearance + depth, std::sqrt(radius * radius - (radius - depth) * (radius - depth))};
}

double CuttingMotion::time(const CuttingSpec& cutting, std::size_t gap, std::size_t node) const {
  const double before = approach.down + approach.along;
  const double way = before + (stroke.high - stroke.low) + approach.along;
  return static_cast<double>(gap) * (way / cutting.feed + cutting.index_time) +
         (before + height(node) - stroke.low) / cutting.feed;
}

std::variant<CuttingMotion, CuttingProblem> plan_cutting(const Machine& machine, const GearJob& job,
                                                         const WheelInGap& wheel, std::size_t nodes,
                                                         const AxisCommands& start,
                                                         const PoseChange& change) {
  CuttingMotion motion;
  motion.stroke = stroke_of(job, wheel);
  motion.approach = approach_of(job);
  motion.nodes = nodes;
  const Plan plan = ideal_plan(machine, true), anywhere = ideal_plan(machine, false);
  if (!axis_sign_of(anywhere, job, wheel, 0, start)) return missing_axes(machine, wheel);
  const std::optional<double> sign = axis_sign_of(plan, job, wheel, motion.stroke.low, start);
  motion.axis_sign = sign.value_or(1);
  PathSolver path(path_options(plan), start);
  const Tool tool = tool_of(machine);
  for (int gap = 0; gap < job.gear.spec.teeth; ++gap)
    for (std::size_t node = 0; node < nodes; ++node) {
      const auto index = static_cast<std::size_t>(gap);
      const TipAndAxis nominal = wheel_pose(job, wheel, index, motion.height(node), motion.axis_sign);
      const TipAndAxis pose = change ? change(index, motion.height(node), nominal) : nominal;
      const InverseResult found = path.pose(plan, tool, pose.position, pose.tool_axis);
      if (!sign || found.status == Status::failed)
        return CuttingProblem{
            CuttingProblem::Trouble::travel,
            fmt::format("gap {}, {:.3f} mm above the middle of the face: the travels of the axes end "
                        "before the wheel is there",
                        gap + 1, motion.height(node))};
      motion.commands.push_back(found.q);
    }
  return motion;
}

}  // namespace abbe
