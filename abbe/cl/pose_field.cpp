#include "abbe/cl/pose_field.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>

#include "abbe/core/units.h"

namespace abbe::cl {
namespace {

constexpr double kSingular = 0.0174524064372835;  // sin 1 deg
constexpr double kSameDirection = 1e-4;           // rad: what printed digits of a tool axis leave
constexpr double kTravelSlack = 1e-6;             // mm or rad
constexpr double kDone = 1e-6;                    // mm: 1 nm
constexpr int kMaxSteps = 20;

PathOptions path_options(AxisSet free) {
  PathOptions options;
  options.free = free;
  options.ideal = true;
  return options;
}

}  // namespace

Query at_rest(const Plan& plan, const Tool& tool, const Vec3& w) {
  Query query;
  query.tool = tool;
  Jacobian columns = jacobian(plan, query);
  for (int i = 0; i < plan.machine().axis_count(); ++i) {
    if (plan.machine().axis(i).type != AxisType::linear) columns.position.col(i).setZero();
  }
  // rotary axes at zero: the tip is affine in the linear ones
  const Eigen::VectorXd dq =
      columns.position.completeOrthogonalDecomposition().solve(w - nominal_tip(plan, query));
  for (int i = 0; i < plan.machine().axis_count(); ++i) query.q[static_cast<std::size_t>(i)] = dq[i];
  return query;
}

Placement placement_of(const Plan& plan, const std::optional<WorkOffset>& offset) {
  Placement placement;
  if (!offset) return placement;
  const Machine& machine = plan.machine();
  Query query;
  query.tool = tool_of(machine, 0);
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& axis = machine.axis(i);
    const std::string& address = axis.address.empty() ? axis.name : axis.address;
    if (axis.type == AxisType::linear && address.size() == 1 && address[0] >= 'X' && address[0] <= 'Z')
      query.q[static_cast<std::size_t>(i)] = offset->origin[static_cast<std::size_t>(address[0] - 'X')];
  }
  placement.origin = nominal_tip(plan, query);
  placement.rotation = Eigen::AngleAxisd(offset->rotation, Vec3::UnitZ()).toRotationMatrix();
  return placement;
}

PoseField::PoseField(const Plan& plan, const Placement& placement, bool probed, AxisSet free,
                     const Commands& start)
    : plan_(plan),
      placement_(placement),
      probed_(probed),
      free_(free),
      tool_(tool_of(plan.machine())),
      path_(path_options(free), start) {
  for (int i = 0; i < plan.machine().axis_count(); ++i) {
    if (plan.machine().axis(i).type != AxisType::rotary || (free >> i & 1U) == 0) continue;
    rotary_ |= AxisSet{1} << i;
    ++rotary_axes_;
  }
  set_tool(tool_);
}

Query PoseField::query(const Commands& q) const {
  Query query;
  query.q = q;
  query.tool = tool_;
  return query;
}

void PoseField::set_tool(const Tool& tool) {
  tool_ = tool;
  datum_ = Vec3::Zero();
  if (!probed_) return;
  const Query rest = at_rest(plan_, tool_, placement_.origin);
  // D0 = actual tip - nominal tip at the program's origin
  const Vec3 shift = actual_tip(plan_, rest) - nominal_tip(plan_, rest);
  if (shift.allFinite()) datum_ = shift;
}

InverseResult PoseField::post(const ToolPose& pose, const Commands& near, int side) const {
  InverseOptions options;
  options.ideal = true;
  options.side = side;
  return inverse(plan_, tool_, placement_.to_workpiece(pose.tip), placement_.rotation * pose.axis, near,
                 free_, options);
}

void PoseField::check(const Commands& q, Trouble& trouble, int& axis) const {
  for (int i = 0; i < plan_.machine().axis_count(); ++i) {
    const auto& range = plan_.machine().axis(i).range;
    const double v = q[static_cast<std::size_t>(i)];
    if (!range || (v >= (*range)[0] - kTravelSlack && v <= (*range)[1] + kTravelSlack)) continue;
    trouble = Trouble::travel;
    axis = i;
    return;
  }
}

PoseField::Place PoseField::place_of(const ToolPose& pose, const InverseResult& found) const {
  Place place;
  place.pose = pose;
  place.q = found.q;
  place.side = found.side;
  // Only two rotary axes have a singularity, and a side of it.
  place.singular = rotary_axes_ == 2 && found.side.distance < kSingular;
  if (found.status == Status::failed || found.residual_direction > kSameDirection)
    place.trouble = Trouble::unreachable;
  check(found.q, place.trouble, place.axis);
  return place;
}

PoseField::Place PoseField::follow(const ToolPose& pose) {
  return place_of(
      pose, path_.pose(plan_, tool_, placement_.to_workpiece(pose.tip), placement_.rotation * pose.axis));
}

PoseField::Place PoseField::between(const ToolPose& pose, const Place& a, const Place& b, double s) const {
  Commands near;
  for (std::size_t i = 0; i < near.size(); ++i) near[i] = a.q[i] + s * (b.q[i] - a.q[i]);
  return place_of(pose, post(pose, near, a.side.sign == b.side.sign ? a.side.sign : 0));
}

Vec3 PoseField::corrected_axis(const Place& place) const {
  if (place.singular || rotary_axes_ == 0) return place.pose.axis;
  CorrectOptions options;
  options.target_shift = datum_;
  const Query at = query(place.q);
  const Correction correction = correct(plan_, at, free_, options);
  if (correction.status == Status::failed) return place.pose.axis;
  const Pose nominal = nominal_pose(plan_, query(correction.corrected));
  const Vec3 axis = placement_.rotation.transpose() * (nominal.R * tool_.axis);
  return axis.allFinite() && axis.norm() > 0 ? Vec3(axis.normalized()) : place.pose.axis;
}

Correction PoseField::corrected_commands(const Place& place, bool turn) const {
  CorrectOptions options;
  options.target_shift = datum_;
  if (place.singular || !turn) options.locked = rotary_;
  return correct(plan_, query(place.q), free_, options);
}

Vec3 PoseField::off_at(const Place& place, const Commands& q, bool ideal) const {
  if (ideal) return nominal_tip(plan_, query(q)) - placement_.to_workpiece(place.pose.tip);
  return actual_tip(plan_, query(q)) - target(place.pose);
}

PoseField::Answer PoseField::corrected_tip(const Place& place, const Vec3& axis,
                                           const Vec3& first_guess) const {
  Answer answer;
  ToolPose written{first_guess, axis};
  for (int step = 0; step < kMaxSteps; ++step) {
    const InverseResult found = post(written, place.q, place.side.sign);
    bool outside = false;
    const Vec3 actual = actual_tip(plan_, query(found.q), &outside);
    // tip' := tip' - (actual tip - target), in the program's axes
    const Vec3 off = placement_.rotation.transpose() * (actual - target(place.pose));
    if (found.status == Status::failed || !off.allFinite()) {
      answer.trouble = found.status == Status::failed ? Trouble::unreachable : Trouble::failed;
      return answer;
    }
    answer.tip = written.tip;
    answer.q = found.q;
    if (off.norm() < kDone) {
      if (outside) answer.trouble = Trouble::outside;
      check(found.q, answer.trouble, answer.axis);
      return answer;
    }
    written.tip -= off;
  }
  answer.trouble = Trouble::failed;
  return answer;
}

std::optional<Vec3> PoseField::left_at(const Place& place, const ToolPose& written) const {
  const InverseResult found = post(written, place.q, place.side.sign);
  if (found.status == Status::failed) return std::nullopt;
  const Vec3 off = actual_tip(plan_, query(found.q)) - target(place.pose);
  return off.allFinite() ? std::optional(off) : std::nullopt;
}

}  // namespace abbe::cl
