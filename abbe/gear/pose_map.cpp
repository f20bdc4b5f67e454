#include "abbe/gear/pose_map.h"

#include <fmt/format.h>

namespace abbe {
namespace {

constexpr std::size_t kDirections = 6;

Twist twist_of(const PoseValues& values, std::size_t group) {
  const double* const v = values.data() + group * kDirections;
  return {Vec3(v[0], v[1], v[2]), Vec3(v[3], v[4], v[5])};
}

}  // namespace

PoseUnknown pose_unknown(std::size_t index) {
  const std::size_t group = index / kDirections;
  return {group >= 2, group % 2 == 1, static_cast<int>(index % kDirections)};
}

std::string name_of(const PoseUnknown& unknown) {
  constexpr std::array kNames = {"x", "y", "z", "a", "b", "c"};
  return fmt::format("{}_{}_{}", unknown.wheel ? "wheel" : "gear", unknown.motion ? "motion" : "static",
                     kNames[static_cast<std::size_t>(unknown.direction)]);
}

RelativeDeviation relative_deviation_at(const GearJob& job, const WheelInGap& wheel, const PoseValues& values,
                                        std::size_t gap, double height) {
  const Mat3 R = gap_axes(job, gap, height);
  const Pose ideal{R, wheel_pose(job, wheel, gap, height, 1).position};
  const RelativeDeviation fixed = relative_deviation(ideal, {twist_of(values, 0), twist_of(values, 2)});
  const RelativeDeviation moving = relative_deviation(ideal, {twist_of(values, 1), twist_of(values, 3)});
  const double part = height / (job.gear.spec.face_width / 2);
  return {fixed.position + part * moving.position, fixed.rotation + part * moving.rotation};
}

WheelDeviations deviations_of(const GearJob& job, const WheelInGap& wheel, const PoseValues& values,
                              const Stroke& stroke, std::size_t nodes) {
  WheelDeviations out(stroke.low, stroke.high, nodes, job.gear.spec.teeth);
  for (std::size_t gap = 0; gap < static_cast<std::size_t>(job.gear.spec.teeth); ++gap)
    for (std::size_t node = 0; node < nodes; ++node) {
      const double height = out.height(node);
      const RelativeDeviation relative = relative_deviation_at(job, wheel, values, gap, height);
      const Mat3 back = gap_axes(job, gap, height).transpose();
      out.of(gap, node) = {back * relative.position, back * relative.rotation};
    }
  return out;
}

}  // namespace abbe
