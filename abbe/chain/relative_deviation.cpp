#include "abbe/chain/relative_deviation.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace abbe {
namespace {

[[nodiscard]] bool belongs_to(const Machine& machine, const ErrorTerm& error, Branch branch) {
  if (error.body == kToolBody) return branch == Branch::tool;
  if (error.body == kWorkpieceBody) return branch == Branch::workpiece;
  return machine.bodies[static_cast<std::size_t>(error.body)].branch == branch;
}

}  // namespace

RelativeDeviation relative_deviation(const Pose& ideal, const PoseDeviations& deviations) {
  const Twist &gear = deviations.gear, &tool = deviations.tool;
  RelativeDeviation relative;
  // dp = R_wt d_t - d_w - e_w x p
  relative.position = ideal.R * tool.d - gear.d - gear.e.cross(ideal.p);
  // e = R_wt e_t - e_w
  relative.rotation = ideal.R * tool.e - gear.e;
  return relative;
}

TipAndAxis corrected_pose(const TipAndAxis& wanted, const std::vector<RelativeDeviation>& deviations) {
  TipAndAxis pose = wanted;
  for (const RelativeDeviation& relative : deviations) {
    pose.position -= relative.position;
    pose.tool_axis -= relative.rotation.cross(wanted.tool_axis);
  }
  const double length = pose.tool_axis.norm();
  if (length > 0) pose.tool_axis /= length;
  return pose;
}

std::vector<std::string> errors_of(const Machine& machine, Branch branch) {
  std::vector<std::string> names;
  for (const ErrorTerm& error : machine.errors) {
    if (belongs_to(machine, error, branch)) names.push_back(to_string(error.name));
  }
  return names;
}

Machine without_errors_of(Machine machine, Branch branch) {
  const auto gone = std::remove_if(machine.errors.begin(), machine.errors.end(), [&](const ErrorTerm& error) {
    return belongs_to(machine, error, branch);
  });
  machine.errors.erase(gone, machine.errors.end());
  return machine;
}

}  // namespace abbe
