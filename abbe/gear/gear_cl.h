#pragma once

#include <string>

#include "abbe/gear/cutting_motion.h"

namespace abbe {

/// The cut as CL data: wheel centre and wheel axis in the workpiece frame, every gap with a stroke upwards.
///
/// The stroke begins and ends where the wheel is out of the material (approach_of); between strokes the wheel
/// is `clearance` outside the tip cylinder. Points lie so close that straight motions stay within `tolerance`
/// of the helix, of the crowning and of the tip cylinder's clearance.
///
/// tolerance   mm
/// change      null: nominal poses
/// laws        EveryGapIsCutOnce, TheWheelStartsOutsideTheGear
[[nodiscard]] std::string write_gear_cl(const GearJob& job, const WheelInGap& wheel, double axis_sign,
                                        double tolerance, const PoseChange& change = {});

}  // namespace abbe
