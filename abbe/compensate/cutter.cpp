#include "abbe/compensate/cutter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace abbe {
namespace {

constexpr double kSpare = 1.05;
// A turn this near to half a turn, rad.
constexpr double kBack = 1e-6;
// Smaller ways in the plane are rounding of double arithmetic, mm.
constexpr double kNoWay = 1e-7;
// An arc around the cutter leaves its centre at least this radius, mm.
constexpr double kLeastRadius = 1e-3;

Vec3 in_plane(const Vec3& v) { return {v.x(), v.y(), 0}; }

double narrowing(const PlaneWay& way, double offset) {
  if (way.radius * offset <= 0) return 1;
  const double radius = std::abs(way.radius), cutter = std::abs(offset);
  return radius > cutter ? radius / (radius - cutter) : std::numeric_limits<double>::infinity();
}

}  // namespace

std::optional<PlaneWay> straight_way(const Vec3& start, const Vec3& end) {
  const Vec3 way = in_plane(end - start);
  const double length = way.norm();
  if (!(length > kNoWay)) return std::nullopt;
  return PlaneWay{way / length, way / length, length, 0};
}

std::optional<PlaneWay> arc_way(const Vec3& start, const Vec3& end, const Centre& centre, bool clockwise) {
  const auto arc = arc_about(Plane::xy, start, end, centre.a, centre.b, clockwise, 1);
  if (!arc) return std::nullopt;
  const double radius = std::min(arc->r0, arc->r1);
  return PlaneWay{in_plane(arc->direction(0)).normalized(), in_plane(arc->direction(1)).normalized(),
                  radius * std::abs(arc->sweep), clockwise ? -radius : radius};
}

Vec3 to_centre(const Vec3& tangent, double offset) {
  const double length = std::hypot(tangent.x(), tangent.y());
  if (!(length > 0)) return Vec3::Zero();
  return Vec3(-tangent.y(), tangent.x(), 0) * (offset / length);
}

double cut_off(const PlaneWay& before, const PlaneWay& after, double offset) {
  if (offset == 0) return 0;
  // theta > 0 turns left; the cutter is on the left for offset > 0
  const Vec3 &a = before.last, &b = after.first;
  const double theta = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  const bool back = std::abs(theta) > std::numbers::pi - kBack;  // no side of it is the inner one
  if (theta * offset <= 0 && !back) return 0;
  // l = |offset| tan(theta / 2)
  const double straight = std::abs(offset) * std::tan(std::abs(theta) / 2);
  return straight * std::max(narrowing(before, offset), narrowing(after, offset));
}

bool too_narrow(const PlaneWay& way, double offset) {
  return way.radius * offset > 0 && std::abs(way.radius) < std::abs(offset) + kLeastRadius;
}

bool corner_fits(const PlaneWay& before, const PlaneWay& after, double offset) {
  return kSpare * cut_off(before, after, offset) <= std::min(before.length, after.length);
}

}  // namespace abbe
