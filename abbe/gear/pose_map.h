#pragma once

#include <array>
#include <string>

#include "abbe/chain/relative_deviation.h"
#include "abbe/gear/cutting_motion.h"

namespace abbe {

/// One of the 24 deviations of the two bodies that meet in the cut: of gear or wheel, the same everywhere
/// (static) or growing along the stroke (motion), one of six directions.
struct PoseUnknown {
  bool wheel =
      false;  ///< of the wheel, axes of the gap at its centre; else of the gear, workpiece axes and origin
  bool motion = false;  ///< times height / (half the face width); else constant
  int direction = 0;    ///< 0..2 displacement along x y z, 3..5 rotation about them
};
inline constexpr std::size_t kPoseUnknowns = 24;
using PoseValues = std::array<double, kPoseUnknowns>;  ///< mm and rad

/// Gear static, gear motion, wheel static, wheel motion; of each x y z a b c.
[[nodiscard]] PoseUnknown pose_unknown(std::size_t index);
/// "gear_static_x", "wheel_motion_c".
[[nodiscard]] std::string name_of(const PoseUnknown& unknown);

/// The deviation of the wheel against the gear that these make at a place, in workpiece axes:
///     dp = R d_wheel - d_gear - e_gear x p,   e = R e_wheel - e_gear       (relative_deviation.h), static +
///     motion
[[nodiscard]] RelativeDeviation relative_deviation_at(const GearJob& job, const WheelInGap& wheel,
                                                      const PoseValues& values, std::size_t gap,
                                                      double height);

/// The same in all gaps and at all heights of a stroke, in the axes of the gaps.
/// laws   AWheelMovedIsAGearMovedTheOtherWay
[[nodiscard]] WheelDeviations deviations_of(const GearJob& job, const WheelInGap& wheel,
                                            const PoseValues& values, const Stroke& stroke,
                                            std::size_t nodes);

}  // namespace abbe
