#pragma once

#include "abbe/core/linear_algebra.h"
#include "abbe/gear/gear.h"

namespace abbe {

/// The two flanks of a gap, seen from the end at +z with the gap upwards: the gap's left side is the right
/// flank of the tooth beside it.
///
/// In the frame of the gap (x radially outwards through its middle at z = 0, y tangential, z the gear axis)
/// the right flank is at +y.
enum class Flank { right, left };
[[nodiscard]] constexpr double side_of_gap(Flank flank) { return flank == Flank::right ? 1.0 : -1.0; }

/// Which modifications of the drawing are in a surface.
enum class Modified { none, profile, all };

/// Depth of the modification, transverse along the base tangent, not positive.
///     tip relief, linear over its roll length; profile crowning, a parabola between form and tip
[[nodiscard]] double profile_modification(const Gear& gear, double roll);
/// Helix crowning: -C (2 z / b)^2.
[[nodiscard]] double helix_modification(const Gear& gear, double z);

/// A point of the flank, its unit normal out of the material, and the transverse base tangent, along which
/// deviations are measured; frame of the gap.
struct FlankPoint {
  Vec3 position = Vec3::Zero();  ///< mm
  Vec3 normal = Vec3::Zero();
  Vec3 tangent = Vec3::Zero();  ///< unit vector in the transverse plane, out of the material
};

/// With s = +1 (right) or -1 (left), phi = xi + eta - inv alpha_t, in the transverse plane turned by kappa z:
///
///     P = r_b (cos phi + xi sin phi, s (sin phi - xi cos phi)),   t = (sin phi, -s cos phi)
///     design point = P + m t,   m = modification;   normal = the cross product of its two derivatives
///
/// z       from the middle of the face
/// laws    NormalIsAcrossTheSurface, RadiusFollowsTheRoll, LeftIsRightTurnedOver
/// cost    two sines
/// source  docs/theory/gears.md, (4)
[[nodiscard]] FlankPoint flank_point(const Gear& gear, Flank flank, double roll, double z, Modified modified);

}  // namespace abbe
