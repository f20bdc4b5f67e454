#pragma once

// What a cutter removes, by the plainest means: poses close together, points in or out. Test support.

#include <cmath>
#include <optional>
#include <vector>

#include "abbe/part/cutter.h"
#include "abbe/part/sweep.h"

namespace abbe {

/// Is the point inside the cutter at this pose? From the shapes: cylinder, disc and ball (or torus).
inline bool inside_cutter(const Cutter& cutter, const ToolPose& pose, double worn, const Vec3& point) {
  const Vec3 x = point - pose.tip;
  const double h = x.dot(pose.axis), rho = (x - h * pose.axis).norm();
  const double core = cutter.radius - cutter.corner;
  if (cutter.corner > 0) {
    if (h < worn || rho > cutter.radius - worn) return false;
    if (h >= cutter.corner) return h <= cutter.length;
    if (rho <= core) return true;
    return std::hypot(rho - core, cutter.corner - h) <= cutter.corner - worn;
  }
  return h >= worn && h <= cutter.length && rho <= cutter.radius - worn;
}

/// The least t at which the ray is inside one of `poses` poses on the piece: steps along the ray, then
/// halving.
inline std::optional<double> brute_force_entry(const Cutter& cutter, const SweepPiece& piece, const Ray& ray,
                                               int poses, int steps) {
  std::optional<double> best;
  for (int k = 0; k <= poses; ++k) {
    const double s = static_cast<double>(k) / poses;
    const ToolPose pose{piece.from.tip + s * (piece.to.tip - piece.from.tip),
                        (piece.from.axis + s * (piece.to.axis - piece.from.axis)).normalized()};
    const auto inside = [&](double t) { return inside_cutter(cutter, pose, piece.worn, ray.p + t * ray.n); };
    double in = ray.low;
    if (!inside(in)) {
      const double step = (ray.high - ray.low) / steps;
      int i = 1;
      while (i <= steps && !inside(ray.low + i * step)) ++i;
      if (i > steps) continue;
      double out = ray.low + (i - 1) * step;
      in = ray.low + i * step;
      while (in - out > 1e-10) (inside((in + out) / 2) ? in : out) = (in + out) / 2;
    }
    if (!best || in < *best) best = in;
  }
  return best;
}

}  // namespace abbe
