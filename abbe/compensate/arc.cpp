#include "abbe/compensate/arc.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace abbe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
// Two ends of an arc closer than this are the same point to every control, mm.
constexpr double kSamePoint = 1e-9;
// Moving the centre by 0.2 mm must be worth 0.02 um of path: what a short arc's rounding cannot say.
constexpr double kRidge = (2e-5 / 0.2) * (2e-5 / 0.2);

}  // namespace

Vec3 Arc::at(double s) const {
  const auto [a, b, n] = plane_axes(plane);
  const double angle = a0 + s * sweep, r = r0 + s * (r1 - r0);
  Vec3 p;
  p[a] = centre_a + r * std::cos(angle);
  p[b] = centre_b + r * std::sin(angle);
  p[n] = h0 + s * (h1 - h0);
  return p;
}

Vec3 Arc::direction(double s) const {
  const auto [a, b, n] = plane_axes(plane);
  const double angle = a0 + s * sweep, r = r0 + s * (r1 - r0);
  Vec3 t;
  t[a] = -r * sweep * std::sin(angle) + (r1 - r0) * std::cos(angle);
  t[b] = r * sweep * std::cos(angle) + (r1 - r0) * std::sin(angle);
  t[n] = h1 - h0;
  const double norm = t.norm();
  return norm > 0 ? Vec3(t / norm) : Vec3::Zero();
}

double Arc::length() const { return std::hypot(std::max(r0, r1) * std::abs(sweep), h1 - h0); }

std::optional<Arc> arc_about(Plane plane, const Vec3& start, const Vec3& end, double centre_a,
                             double centre_b, bool clockwise, int turns) {
  const auto [a, b, n] = plane_axes(plane);
  Arc arc;
  arc.plane = plane;
  arc.centre_a = centre_a;
  arc.centre_b = centre_b;
  arc.r0 = std::hypot(start[a] - centre_a, start[b] - centre_b);
  arc.r1 = std::hypot(end[a] - centre_a, end[b] - centre_b);
  if (!(arc.r0 > kSamePoint) || !(arc.r1 > kSamePoint)) return std::nullopt;
  arc.a0 = std::atan2(start[b] - centre_b, start[a] - centre_a);
  const double a1 = std::atan2(end[b] - centre_b, end[a] - centre_a);
  double sweep = clockwise ? arc.a0 - a1 : a1 - arc.a0;
  const bool closed = std::hypot(end[a] - start[a], end[b] - start[b]) < kSamePoint;
  if (closed) sweep = kTurn;
  while (sweep <= 0) sweep += kTurn;
  while (sweep > kTurn) sweep -= kTurn;
  sweep += kTurn * (turns - 1);
  arc.sweep = clockwise ? -sweep : sweep;
  arc.h0 = start[n];
  arc.h1 = end[n];
  return arc;
}

std::optional<Centre> centre_of_radius(Plane plane, const Vec3& start, const Vec3& end, double r,
                                       bool clockwise) {
  const auto [a, b, n] = plane_axes(plane);
  static_cast<void>(n);
  const double da = end[a] - start[a], db = end[b] - start[b];
  const double chord = std::hypot(da, db);
  if (!(chord > kSamePoint) || !(std::abs(r) > 0)) return std::nullopt;
  const double half = chord / 2;
  if (half > std::abs(r) * (1 + 1e-3)) return std::nullopt;
  // h: distance of the centre from the chord; to its left for a counter-clockwise minor arc
  const double h = std::sqrt(std::max(0.0, r * r - half * half));
  const double side = (clockwise == (r > 0)) ? -1.0 : 1.0;
  return Centre{start[a] + da / 2 - side * h * db / chord, start[b] + db / 2 + side * h * da / chord};
}

Centre fit_centre(const Arc& nominal, const Vec3& start, const Vec3& end,
                  std::span<const ArcTarget> targets) {
  const auto axes = plane_axes(nominal.plane);
  const int a = axes[0], b = axes[1];
  using Vec2 = Eigen::Vector2d;
  const Vec2 c(nominal.centre_a, nominal.centre_b);
  const auto normal = [&](double s) {
    const double angle = nominal.a0 + s * nominal.sweep;
    return Vec2(std::cos(angle), std::sin(angle));
  };
  // rho(s): radius at which the point stands about the nominal centre, less the nominal radius
  const auto rho = [&](double s, const Vec3& p) {
    return normal(s).dot(Vec2(p[a], p[b]) - c) - (nominal.r0 + s * (nominal.r1 - nominal.r0));
  };
  const Vec2 n0 = normal(0), n1 = normal(1);
  const double rho0 = rho(0, start), rho1 = rho(1, end);
  // Unless the targets say otherwise the centre moves with the ends: d = prior + x.
  const auto off = [&](double t, const Vec3& p) {
    const Vec3 nominal_point = nominal.at(t);
    return Vec2(p[a] - nominal_point[a], p[b] - nominal_point[b]);
  };
  const Vec2 prior = (off(0, start) + off(1, end)) / 2;
  // minimise sum_k ( [rho_k - lerp(rho0, rho1)] - [n_k - lerp(n0, n1)] . d )^2 + ( [rho0 - rho1] - [n0 - n1]
  // . d )^2
  //          + kRidge |x|^2 (4)
  Eigen::Matrix2d lhs = (n0 - n1) * (n0 - n1).transpose() + kRidge * Eigen::Matrix2d::Identity();
  Vec2 rhs = (n0 - n1) * (rho0 - rho1 - (n0 - n1).dot(prior));
  for (const auto& target : targets) {
    const double s = target.s;
    const Vec2 row = normal(s) - ((1 - s) * n0 + s * n1);
    lhs += row * row.transpose();
    rhs += row * (rho(s, target.point) - ((1 - s) * rho0 + s * rho1) - row.dot(prior));
  }
  const Vec2 d = prior + lhs.inverse() * rhs;
  return {c.x() + d.x(), c.y() + d.y()};
}

double distance_to(const Arc& arc, std::span<const ArcTarget> targets) {
  double worst = 0;
  for (const auto& target : targets) {
    const Vec3 off = target.point - arc.at(target.s);
    const Vec3 along = arc.direction(target.s);
    worst = std::max(worst, (off - off.dot(along) * along).norm());
  }
  return worst;
}

Arc piece_of(const Arc& arc, double s0, double s1) {
  Arc piece = arc;
  piece.r0 = arc.r0 + s0 * (arc.r1 - arc.r0);
  piece.r1 = arc.r0 + s1 * (arc.r1 - arc.r0);
  piece.h0 = arc.h0 + s0 * (arc.h1 - arc.h0);
  piece.h1 = arc.h0 + s1 * (arc.h1 - arc.h0);
  piece.a0 = arc.a0 + s0 * arc.sweep;
  piece.sweep = (s1 - s0) * arc.sweep;
  return piece;
}

}  // namespace abbe
