#pragma once

#include <string>
#include <vector>

#include "abbe/chain/predict.h"

namespace abbe {

/// Measured deviations of the two poses that meet in the cut, of one origin (static, or of a motion):
/// twelve numbers.
struct PoseDeviations {
  Twist gear;  ///< of the workpiece, workpiece axes, at the workpiece origin
  Twist tool;  ///< axes of the ideal tool, at the tip
};

/// What the part sees of them: six numbers.
struct RelativeDeviation {
  Vec3 position = Vec3::Zero();  ///< of the tip against the part, workpiece axes, mm
  Vec3 rotation = Vec3::Zero();  ///< of the tool against the part, workpiece axes, rad
};

///     dp = R_wt d_t - d_w - e_w x p,     e = R_wt e_t - e_w
///
/// ideal   T_wt of the machine without errors at this pose: its R says how the tool is turned about
///         its own axis, which no tool direction says
/// laws    AMovedGearIsAMovedToolTheOtherWay
/// source  docs/theory/correction.md, section 9
[[nodiscard]] RelativeDeviation relative_deviation(const Pose& ideal, const PoseDeviations& deviations);

/// The pose to ask for, so that with the deviations the wanted one appears (first order; the rest is their
/// square: 1e-7 mm for 0.015 mm):
///
///     p' = p - sum dp,     u' = (u - sum e x u) / |..|
///
/// wanted  tip in workpiece axes and unit tool axis
[[nodiscard]] TipAndAxis corrected_pose(const TipAndAxis& wanted,
                                        const std::vector<RelativeDeviation>& deviations);

/// Names of the machine's errors that belong to one side of the chain: its bodies, and the mounting of
/// workpiece or tool. A measured deviation of that side may contain them.
[[nodiscard]] std::vector<std::string> errors_of(const Machine& machine, Branch branch);
/// The machine without them.
[[nodiscard]] Machine without_errors_of(Machine machine, Branch branch);

}  // namespace abbe
