#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "abbe/core/linear_algebra.h"

namespace abbe {

/// A place on a surface in its own parameters.
struct SurfacePlace {
  double u = 0, v = 0;
};

/// A tensor-product rational B-spline surface, the nominal form of a part:
///
///     S(u, v) = sum_ij N_i(u) M_j(v) w_ij P_ij / sum_ij N_i(u) M_j(v) w_ij
///
/// index 0 of the pairs belongs to u, 1 to v. P_ij stands at points[i * count[1] + j], mm, part axes.
/// Made by read_surface() or by hand; is_valid() says whether the numbers fit together.
struct NurbsSurface {
  static constexpr int kMaxDegree = 7;
  static constexpr std::size_t kMaxPoints = 40000;
  static constexpr double kLongest = 1e6;  ///< mm: coordinates beyond are refused

  std::string name;
  std::array<int, 2> degree{1, 1};
  std::array<std::size_t, 2> count{2, 2};
  std::array<std::vector<double>, 2> knots;  ///< count + degree + 1 each, not decreasing
  std::vector<Vec3> points;
  std::vector<double> weights;  ///< > 0, as many as points
  double outward = 1;           ///< the normal out of the material is outward * (S_u x S_v) / |..|; +1 or -1

  [[nodiscard]] std::array<double, 2> range(std::size_t direction) const {
    const auto p = static_cast<std::size_t>(degree[direction]);
    return {knots[direction][p], knots[direction][count[direction]]};
  }
  [[nodiscard]] bool is_valid() const;
};

/// Knots 0..0 1/n 2/n .. 1..1 that begin and end in the corner points.
[[nodiscard]] std::vector<double> uniform_knots(std::size_t count, int degree);

/// A point of the surface with its derivatives.
struct SurfacePoint {
  Vec3 p = Vec3::Zero();                    ///< mm
  Vec3 u = Vec3::Zero(), v = Vec3::Zero();  ///< dS/du, dS/dv
  Vec3 uu = Vec3::Zero(), uv = Vec3::Zero(), vv = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< unit, out of the material; zero where S_u and S_v are parallel
  [[nodiscard]] bool is_regular() const { return normal != Vec3::Zero(); }
  /// One of S_u, S_v vanishes: a row of the net lies in one place.
  [[nodiscard]] bool is_pole() const {
    const double a = u.squaredNorm(), b = v.squaredNorm();
    return !(std::min(a, b) > 1e-18 * std::max(a, b));
  }
};

/// At a pole on the rim the normal is the limit along the line that ends there; S_v = 0 at the end u_0 gives
///
///     n ~ S_u x S_uv sign(u - u_0),   for S_v = (u - u_0) S_uv + ..
///
/// errors   a place outside the range is taken to its border; `surface` must be valid; a pole elsewhere, or
///          where the limit does not exist either, has no normal
/// laws     APoleHasTheNormalBesideIt, DerivativesAreDifferenceQuotients, SphereAndCylinderAreExact,
///          AffineMapsOfThePointsMapTheSurface
/// cost     (p + 1)(q + 1) points; 0.5 us for bicubic; no allocation
/// source   Piegl, Tiller: The NURBS Book (1997), A2.1, A2.3, A4.4
[[nodiscard]] SurfacePoint evaluate(const NurbsSurface& surface, SurfacePlace place);

/// How the surface bends, 1/mm: positive where it bends towards its outward normal (a hollow, where a ball
/// cutter must be smaller than 1 / k), negative on a hump.
///
///     k(d) = II(d) / I(d), II by the outward normal;  k1 <= k2 the extremes over all tangents d
struct Curvature {
  double least = 0, most = 0;
  [[nodiscard]] double mean() const { return (least + most) / 2; }
  [[nodiscard]] double gauss() const { return least * most; }
};
/// errors   zero at a point that is not regular
[[nodiscard]] Curvature curvature_at(const SurfacePoint& point);

/// In the direction of a tangent (any length; zero gives 0).
[[nodiscard]] double curvature_along(const SurfacePoint& point, const Vec3& tangent);

/// Equally spaced places, `rows` in u by `columns` in v, at the middle of equal cells: no place lies on the
/// rim.
[[nodiscard]] std::vector<SurfacePlace> cell_places(const NurbsSurface& surface, std::size_t rows,
                                                    std::size_t columns);

}  // namespace abbe
