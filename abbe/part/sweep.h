#pragma once

#include <optional>

#include "abbe/core/linear_algebra.h"
#include "abbe/part/cutter.h"

namespace abbe {

/// Where a tool is: its tip and the unit vector from the tip to the spindle, part axes, mm.
struct ToolPose {
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
};

/// A short piece of a tool's way: tip and axis go linearly from one pose to the next.
struct SweepPiece {
  ToolPose from, to;
  double worn = 0;  ///< mm that the cutter has lost all over
};

/// A directed line p + t n with |n| = 1, looked at from t = low to t = high.
struct Ray {
  Vec3 p = Vec3::Zero(), n = Vec3::UnitZ();
  double low = -1, high = 1;  ///< mm
};

/// The least t in [low, high] at which the ray is inside what the cutter sweeps on this piece; `low` if it is
/// inside there already; nullopt if it stays outside.
///
/// Balls whose shank is not near: the capsule about the centre's way, in closed form. Else, with f the
/// distance to the cutter at the share s of the piece (convex in s and t for a tool that does not turn):
///
///     m(t) = min_s f(s, t),   Newton from the left:  t := t - m / m'    (never beyond the root, for m is
///     convex)
///
/// bound    of the root 1e-9 mm; a tool that turns by a on the piece: besides length * a^2 / 8
/// laws     EqualsDenseSampling, BallEqualsTheGeneralWay, MovingBothMovesNothing
/// cost     20 ns for a ball, about 1 us for another cutter that hits, 0.1 us for one that misses
[[nodiscard]] std::optional<double> entry_of(const Cutter& cutter, const SweepPiece& piece, const Ray& ray);

/// The same by the general way only, for tests.
[[nodiscard]] std::optional<double> entry_of_any(const Cutter& cutter, const SweepPiece& piece,
                                                 const Ray& ray);

}  // namespace abbe
