#pragma once

#include <cmath>

#include "abbe/core/linear_algebra.h"

namespace abbe {

/// A turning cutter as the solid that it removes: bull-nose; ball for corner = radius; flat for corner = 0.
///
///     all points within `corner` of the cylinder  corner <= h <= length, rho <= radius - corner
///
/// h along the tool axis from the tip, rho the distance from the axis. Convex, and so is its distance
/// function.
struct Cutter {
  double radius = 3;   ///< mm
  double corner = 3;   ///< mm, 0 to radius
  double length = 30;  ///< mm, from the tip: what lies above is not looked at

  [[nodiscard]] bool is_ball() const { return corner == radius; }
  [[nodiscard]] bool is_valid() const {
    return std::isfinite(radius) && std::isfinite(length) && radius > 0 && corner >= 0 && corner <= radius &&
           length >= corner;
  }
};

/// Signed distance to the solid (mm, < 0 inside) and how it grows with h and rho.
struct CutterDistance {
  double value = 0, along = 0, across = 0;
};

/// worn  mm taken off all over: the corner's rounding first, then the cylinder within
/// laws  DistanceIsThatOfTheNearestPoint, SmoothOutside (a kink there would spoil Newton's method)
[[nodiscard]] inline CutterDistance cutter_distance(const Cutter& cutter, double worn, double h, double rho) {
  const double beyond = worn > cutter.corner ? worn - cutter.corner : 0;
  const double off = worn > cutter.corner ? 0 : worn - cutter.corner;
  // To the inner cylinder, then `off` nearer.
  const double below = cutter.corner + beyond - h, above = h - cutter.length + beyond;
  const double a = below > above ? below : above, sign = below > above ? -1.0 : 1.0;
  const double b = rho - (cutter.radius - cutter.corner - beyond);
  if (a > 0 && b > 0) {
    const double d = std::hypot(a, b);
    return {d + off, sign * a / d, b / d};
  }
  return a > b ? CutterDistance{a + off, sign, 0} : CutterDistance{b + off, 0, 1};
}

}  // namespace abbe
