#include "abbe/chain/control_kinematics.h"

#include <Eigen/LU>
#include <cmath>
#include <variant>

#include "abbe/chain/predict.h"

namespace abbe {
namespace {

constexpr double kProbe = 1024;        // mm, a power of two: the division is exact
constexpr double kIndependent = 1e-3;  // least determinant of three directions

Plan believed_plan(const Machine& machine) { return std::get<Plan>(make_plan(as_believed(machine), {})); }

}  // namespace

AddressedAxes addressed_axes(const Machine& machine) {
  AddressedAxes axes;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& body = machine.axis(i);
    if (body.address.size() != 1) continue;
    const char letter = body.address[0];
    if (body.type == AxisType::linear && letter >= 'X' && letter <= 'Z')
      axes.linear[static_cast<std::size_t>(letter - 'X')] = i;
    if (body.type == AxisType::rotary && letter >= 'A' && letter <= 'C')
      axes.rotary[static_cast<std::size_t>(letter - 'A')] = i;
  }
  return axes;
}

Affine after(const Affine& first, const Affine& second) {
  return {second.A * first.A, second.A * first.b + second.b};
}

std::optional<Affine> inverse(const Affine& map) {
  if (!(std::abs(map.A.determinant()) > kIndependent)) return std::nullopt;
  const Mat3 A = map.A.inverse();
  return Affine{A, -(A * map.b)};
}

ControlKinematics::ControlKinematics(const Machine& machine, const AddressedAxes& axes)
    : believed_(believed_plan(machine)), axes_(axes) {}

Query ControlKinematics::query(const Vec3& m, const Turns& turns, const Tool& tool) const {
  Query query;
  query.tool = tool;
  for (std::size_t k = 0; k < 3; ++k) {
    if (axes_.linear[k] >= 0)
      query.q[static_cast<std::size_t>(axes_.linear[k])] = m[static_cast<Eigen::Index>(k)];
    if (axes_.rotary[k] >= 0) query.q[static_cast<std::size_t>(axes_.rotary[k])] = turns[k];
  }
  return query;
}

Affine ControlKinematics::tip_of_axes(const Turns& turns, const Tool& tool) const {
  Affine map;
  map.b = nominal_tip(believed_, query(Vec3::Zero(), turns, tool));
  for (Eigen::Index k = 0; k < 3; ++k)
    map.A.col(k) =
        (nominal_tip(believed_, query(Vec3(kProbe * Vec3::Unit(k)), turns, tool)) - map.b) / kProbe;
  return map;
}

std::optional<Affine> ControlKinematics::axes_of_points(const Turns& turns, double length) const {
  const Tool tool = tool_of(believed(), length);
  const auto back = inverse(tip_of_axes(turns, tool));
  if (!back) return std::nullopt;
  return after(tip_of_axes(Turns{}, tool), *back);
}

TipAndAxis ControlKinematics::pose(const Vec3& m, const Turns& turns, const Tool& tool) const {
  const Pose at = nominal_pose(believed_, query(m, turns, tool));
  return {at.p, at.R * tool.axis};
}

}  // namespace abbe
