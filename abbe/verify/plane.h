#pragma once

#include <optional>

#include "abbe/machine/control_model.h"
#include "abbe/verify/rotary.h"

namespace abbe::verifying {

/// The angle between the control's tool and the normal of a plane, rad. `normal` in the directions of the
/// program's points, as they are with all rotary axes at zero.
[[nodiscard]] double askew(const Rotary& rotary, const Vec3& normal, const Turns& turns);

/// Where the rotary axes stand when the tool has been laid along `normal`, beginning at `from`: one axis
/// after the other goes to where the tool is nearest to it,
///
///   d(angle) . n = a + b cos(angle) + c sin(angle),   angle = atan2(c, b)
///
/// errors   nullopt: the tool does not get there
/// cost     three evaluations of the chain per axis and round
[[nodiscard]] std::optional<Turns> laid_along(const Rotary& rotary, const Vec3& normal, Turns from);

/// The same for a control that takes the way with one axis on one side of zero, wherever the axes are; where
/// that axis is at zero they stay. errors   nullopt too: there are several such ways
[[nodiscard]] std::optional<Turns> laid_on_side(const Rotary& rotary, const Vec3& normal, const Turns& from,
                                                const TiltSolution& side);

}  // namespace abbe::verifying
