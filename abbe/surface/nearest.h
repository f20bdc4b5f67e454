#pragma once

#include <vector>

#include "abbe/surface/nurbs.h"

namespace abbe {

/// The foot of a point on a surface.
struct SurfaceFoot {
  SurfacePlace place;
  SurfacePoint at;
  double deviation = 0;  ///< mm: (point - foot) . outward normal; + = material left on
  double distance = 0;   ///< mm: |point - foot|; more than |deviation| only off the rim
  bool on_rim = false;   ///< the foot lies on the border of the range
  /// The point lies on the normal at its foot. Where it does not inside the rim, the foot is on a crease and
  /// the deviation is the distance with the sign of that side.
  bool is_normal = true;
};

/// Finds the nearest point of one surface for many points.
///
///     minimise |S(u, v) - q|^2 by Newton's method in u and v, from the nearest samples of a grid
///
/// The minimum is the global one wherever the surface between two samples bends less than it is far from a
/// second minimum: kSamples samples per knot span and direction, the best three of them tried. On the rim the
/// foot is the best point of the border.
///
/// errors   a point that is not finite gives the first sample and deviation 0; deviation 0 as well where the
///          foot has no normal (SurfacePoint::is_regular)
/// laws     BesideACreaseTheDeviationIsTheDistance, FootOfAPointOnTheNormalIsItsBase, NoSampleIsNearer,
///          SphereGivesRadiusDifference
/// cost     the samples (6 flops each) and 3 to 6 evaluations per start; immutable, shared by threads
class NearestPoint {
 public:
  static constexpr std::size_t kSamples = 6;

  /// `surface` must be valid; it is copied.
  explicit NearestPoint(NurbsSurface surface);

  [[nodiscard]] SurfaceFoot operator()(const Vec3& point) const;
  /// From a place that is already known to be near.
  [[nodiscard]] SurfaceFoot from(SurfacePlace start, const Vec3& point) const;
  [[nodiscard]] const NurbsSurface& surface() const { return surface_; }

 private:
  NurbsSurface surface_;
  std::vector<SurfacePlace> places_;
  std::vector<Vec3> samples_;
};

/// Parameters that cut every knot span of one direction into `pieces` equal ones, both ends included.
[[nodiscard]] std::vector<double> span_samples(const NurbsSurface& surface, std::size_t direction,
                                               std::size_t pieces);

}  // namespace abbe
