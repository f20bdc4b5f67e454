#include "abbe/gear/cutting_motion.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "abbe/chain/solve_path.h"

namespace abbe {
namespace {

constexpr int kMostPoints = 2000;  // between two gaps
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

double angle_of(const GearJob& job, std::size_t gap, double height) {
  return job.cutting.first_gap + kTurn * static_cast<double>(gap) / job.gear.spec.teeth +
         job.gear.turn_per_mm * height;
}

/// The wheel outside the tip cylinder, at any angle and height.
TipAndAxis outside_pose(const GearJob& job, const WheelInGap& wheel, double angle, double height,
                        double axis_sign) {
  const Mat3 R = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
  return {
      R * Vec3(wheel.centre_distance + approach_of(job).down, 0, 0) + Vec3(0, 0, job.cutting.middle + height),
      axis_sign * (R * wheel.axis)};
}

/// Leads the machine from pose to pose; where that fails, `problem` says why.
class Follower {
 public:
  Follower(const Plan& plan, const AxisCommands& start)
      : plan_(plan), tool_(tool_of(plan.machine())), path_(path_options(plan), start) {}

  /// Commands for a pose between two gaps.
  [[nodiscard]] std::optional<AxisCommands> reach(const TipAndAxis& pose, std::size_t gap,
                                                  const std::string& where) {
    const InverseResult found = path_.pose(plan_, tool_, pose.position, pose.tool_axis);
    if (found.status == Status::failed) {
      fail(gap, where, "the travels of the axes end before the wheel is there");
      return std::nullopt;
    }
    last_ = found.q;
    return found.q;
  }
  /// The same after another pose in the gap: no axis may go back by a turn to stay within its travel there.
  [[nodiscard]] std::optional<AxisCommands> go_on(const TipAndAxis& pose, std::size_t gap,
                                                  const std::string& where) {
    const AxisCommands before = last_;
    const auto q = reach(pose, gap, where);
    const Machine& machine = plan_.machine();
    for (int i = 0; q && i < machine.axis_count(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (machine.axis(i).type != AxisType::rotary || std::abs((*q)[k] - before[k]) < kTurn / 2) continue;
      fail(gap, where,
           fmt::format("axis {} would have to turn back with the wheel in the gap", machine.axis(i).name));
      return std::nullopt;
    }
    return q;
  }
  [[nodiscard]] const CuttingProblem& problem() const { return problem_; }

 private:
  void fail(std::size_t gap, const std::string& where, const std::string& what) {
    problem_ = {CuttingProblem::Trouble::travel, fmt::format("gap {}, {}: {}", gap + 1, where, what)};
  }

  const Plan& plan_;
  const Tool tool_;
  PathSolver path_;
  AxisCommands last_{};
  CuttingProblem problem_;
};

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
  return Eigen::AngleAxisd(angle_of(job, gap, height), Vec3::UnitZ()).toRotationMatrix();
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

std::vector<TipAndAxis> poses_before_gap(const GearJob& job, const WheelInGap& wheel, std::size_t gap,
                                         double axis_sign) {
  const Stroke stroke = stroke_of(job, wheel);
  const Approach approach = approach_of(job);
  const double low = stroke.low - approach.along, high = stroke.high + approach.along;
  const double to = angle_of(job, gap, low);
  if (gap == 0) return {outside_pose(job, wheel, to, low, axis_sign)};
  const double from = angle_of(job, gap - 1, high);
  // r (1 - cos(step / 2)) <= clearance / 4
  const double radius = wheel.centre_distance + approach.down;
  const double step = 2 * std::acos(std::max(0.0, 1 - job.cutting.clearance / (4 * radius)));
  const int count = std::clamp(static_cast<int>(std::ceil(std::abs(to - from) / step)), 1, kMostPoints);
  std::vector<TipAndAxis> poses;
  for (int i = 1; i <= count; ++i) {
    const double part = static_cast<double>(i) / count;
    poses.push_back(
        outside_pose(job, wheel, from + part * (to - from), high + part * (low - high), axis_sign));
  }
  return poses;
}

TipAndAxis pose_after_gap(const GearJob& job, const WheelInGap& wheel, std::size_t gap, double axis_sign) {
  const double high = stroke_of(job, wheel).high + approach_of(job).along;
  return outside_pose(job, wheel, angle_of(job, gap, high), high, axis_sign);
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
  if (!sign)
    return CuttingProblem{CuttingProblem::Trouble::travel,
                          "the travels of the axes end before the wheel is in gap 1"};
  motion.axis_sign = *sign;
  Follower follower(plan, start);
  const auto pose_at = [&](std::size_t gap, double height) {
    const TipAndAxis nominal = wheel_pose(job, wheel, gap, height, motion.axis_sign);
    return change ? change(gap, height, nominal) : nominal;
  };
  const auto follow = [&](std::size_t gap) {
    const char *in = "on the way into it", *out = "on the way out of it";
    for (const TipAndAxis& pose : poses_before_gap(job, wheel, gap, motion.axis_sign))
      if (!follower.reach(pose, gap, in)) return false;
    if (!follower.go_on(pose_at(gap, motion.stroke.low - motion.approach.along), gap, in)) return false;
    for (std::size_t node = 0; node < nodes; ++node) {
      const double height = motion.height(node);
      const auto q = follower.go_on(pose_at(gap, height), gap,
                                    fmt::format("{:.3f} mm above the middle of the face", height));
      if (!q) return false;
      motion.commands.push_back(*q);
    }
    return follower.go_on(pose_at(gap, motion.stroke.high + motion.approach.along), gap, out) &&
           follower.go_on(pose_after_gap(job, wheel, gap, motion.axis_sign), gap, out);
  };
  for (std::size_t gap = 0; gap < static_cast<std::size_t>(job.gear.spec.teeth); ++gap)
    if (!follow(gap)) return follower.problem();
  return motion;
}

}  // namespace abbe
