#pragma once

#include <optional>
#include <span>

#include "abbe/core/linear_algebra.h"
#include "abbe/program/modal.h"

namespace abbe {

/// A circular, helical or spiral path as the control interpolates it, in program coordinates (mm):
/// angle, radius and height go linearly with s.
///
///   p(s) = c + r(s) (cos a(s), sin a(s)),  a = a0 + s sweep,  r = r0 + s (r1 - r0),  h = h0 + s (h1 - h0)
///   (3)
///
/// sweep > 0 turns from the plane's first axis to its second (G3).
struct Arc {
  Plane plane = Plane::xy;
  double centre_a = 0, centre_b = 0;  ///< first and second axis of the plane
  double r0 = 0, r1 = 0, a0 = 0, sweep = 0, h0 = 0, h1 = 0;

  [[nodiscard]] Vec3 at(double s) const;
  [[nodiscard]] Vec3 direction(double s) const;  ///< unit tangent
  [[nodiscard]] double length() const;           ///< about, mm
};

/// The arc from start to end about a centre. `turns` >= 1; a start equal to the end (in the plane) is a full
/// circle. errors   nullopt: a radius is zero
[[nodiscard]] std::optional<Arc> arc_about(Plane plane, const Vec3& start, const Vec3& end, double centre_a,
                                           double centre_b, bool clockwise, int turns);

/// Centre of the arc with radius |r| from start to end: the minor arc for r > 0, the major one for r < 0.
/// errors   nullopt: start equals end, or they are more than 2 |r| (1 + 1e-3) apart
struct Centre {
  double a = 0, b = 0;
};
[[nodiscard]] std::optional<Centre> centre_of_radius(Plane plane, const Vec3& start, const Vec3& end,
                                                     double r, bool clockwise);

/// A place the output should pass: parameter s of the piece (0..1) and the point, program coordinates.
struct ArcTarget {
  double s = 0;
  Vec3 point = Vec3::Zero();
};

/// The centre with which the arc from `start` to `end` passes closest to the targets with equal radii at
/// both ends, starting from the nominal piece's centre: linear least squares of the radial residuals.
/// source docs/theory/compensation.md, arcs
[[nodiscard]] Centre fit_centre(const Arc& nominal, const Vec3& start, const Vec3& end,
                                std::span<const ArcTarget> targets);

/// Largest distance of the targets from the arc, measured across it.
[[nodiscard]] double distance_to(const Arc& arc, std::span<const ArcTarget> targets);

/// The piece of an arc between two parameters.
[[nodiscard]] Arc piece_of(const Arc& arc, double s0, double s1);

}  // namespace abbe
