#pragma once

#include <optional>

#include "abbe/gear/wheel_deviations.h"

namespace abbe {

/// The deviation of one flank point as the wheel's body cuts it, without first order: the largest depth that
/// the displaced wheel reaches over its stroke, along the transverse base tangent through the design point.
///
///     f = min over t of s:  P + s t lies on the surface of the wheel at height t, moved by (d, Exp e)(t)
///
/// The wheel's profile is not tabulated but solved for at every step. What this differs from flank_deviation
/// by is what that neglects: products of deviations.
///
/// errors   nullopt: the line does not meet the wheel within 1 mm (deviations of another order of magnitude)
/// cost     some 10^4 flank points: for tests, and for a few points of a report
/// source   docs/theory/gears.md, section 3
[[nodiscard]] std::optional<double> cut_exactly(const Gear& gear, const WheelInGap& wheel,
                                                const WheelDeviations& deviations, std::size_t gap,
                                                Flank flank, double roll, double z);

/// Most that flank_deviation differs from cut_exactly at a few points of a few gaps: form, reference and near
/// the tip, at both ends and the middle of the face. nullopt: cut_exactly has no answer somewhere.
[[nodiscard]] std::optional<double> second_order(const Gear& gear, const WheelInGap& wheel,
                                                 const WheelDeviations& deviations);

}  // namespace abbe
