#include "abbe/cl/verify_machine.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

namespace abbe::cl::verifying {
namespace {

constexpr double kPast = 1e-6;   // mm or rad beyond a travel that count as at it
constexpr double kAskew = 1e-4;  // rad: a tool axis the machine does not reach
constexpr int kSteps = 3;        // of a linear problem: the others take away rounding

PathOptions ideal(AxisSet free) {
  PathOptions options;
  options.ideal = true;
  options.free = free;
  return options;
}

}  // namespace

ForwardMachine::ForwardMachine(const Plan& plan, AxisSet free, const std::optional<WorkOffset>& offset,
                               bool probed, const std::array<double, kMaxAxes>& start)
    : plan_(plan), free_(free), probed_(probed), tool_(tool_of(plan.machine())), solver_(ideal(free), start) {
  if (offset) {
    Query nose;
    nose.tool = tool_of(plan.machine(), 0);
    for (std::size_t k = 0; k < 3; ++k) {
      for (int i = 0; i < plan.machine().axis_count(); ++i) {
        const Body& body = plan.machine().axis(i);
        if (body.type == AxisType::linear &&
            (body.address.empty() ? body.name : body.address) == std::string(1, "XYZ"[k]))
          nose.q[static_cast<std::size_t>(i)] = offset->origin[k];
      }
    }
    zero_ = nominal_tip(plan, nose);
    const double c = std::cos(offset->rotation), s = std::sin(offset->rotation);
    turn_ << c, -s, 0, s, c, 0, 0, 0, 1;
  }
  use_tool(tool_);
}

/// Linear axes that hold the tip at w, all others at zero.
Query ForwardMachine::with_linear(const Vec3& w) const {
  Query at;
  at.tool = tool_;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::MatrixXd columns = jacobian(plan_, at).position;
    for (int i = 0; i < plan_.machine().axis_count(); ++i) {
      if (plan_.machine().axis(i).type == AxisType::rotary) columns.col(i).setZero();
    }
    const Eigen::VectorXd by =
        columns.bdcSvd(Eigen::ComputeThinU | Eigen::ComputeThinV).solve(w - nominal_tip(plan_, at));
    for (int i = 0; i < plan_.machine().axis_count(); ++i) at.q[static_cast<std::size_t>(i)] += by[i];
  }
  return at;
}

void ForwardMachine::use_tool(const Tool& tool) {
  tool_ = tool;
  removed_.setZero();
  if (!probed_) return;
  const Query at = with_linear(zero_);
  const Vec3 off = actual_tip(plan_, at) - nominal_tip(plan_, at);
  if (off.allFinite()) removed_ = off;
}

Outcome ForwardMachine::act(const InverseResult& post, const Vec3& axis) const {
  Outcome out;
  out.commands = post.q;
  out.side = post.side.sign;
  Query query;
  query.q = post.q;
  query.tool = tool_;
  const Pose pose = actual_pose(plan_, query, &out.outside);
  const Vec3 real_axis = turn_.transpose() * (pose.R * tool_.axis);
  out.tip = turn_.transpose() * (pose.p - removed_ - zero_);
  out.axis = real_axis.normalized();
  const Vec3 ideal_axis = nominal_pose(plan_, query).R * tool_.axis;
  out.reachable = post.status != Status::failed && out.tip.allFinite() && out.axis.allFinite() &&
                  ideal_axis.cross(turn_ * axis).norm() < kAskew;
  for (int i = 0; i < plan_.machine().axis_count(); ++i) {
    const auto& range = plan_.machine().axis(i).range;
    const double q = post.q[static_cast<std::size_t>(i)];
    if (range && (q < (*range)[0] - kPast || q > (*range)[1] + kPast)) out.beyond = i;
  }
  return out;
}

Outcome ForwardMachine::along(const Vec3& tip, const Vec3& axis) {
  return act(solver_.pose(plan_, tool_, in_workpiece(tip), turn_ * axis), axis);
}

Outcome ForwardMachine::near(const Vec3& tip, const Vec3& axis, const std::array<double, kMaxAxes>& commands,
                             int side) const {
  InverseOptions options;
  options.ideal = true;
  options.side = side;
  return act(inverse(plan_, tool_, in_workpiece(tip), turn_ * axis, commands, free_, options), axis);
}

}  // namespace abbe::cl::verifying
