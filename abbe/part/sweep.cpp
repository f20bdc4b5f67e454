#include "abbe/part/sweep.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace abbe {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kOnIt = 1e-12;    // mm
constexpr double kNarrow = 1e-10;  // of a piece
constexpr int kMostSteps = 60;

/// The part of a line inside a convex body.
struct Span {
  double in = kInfinity, out = -kInfinity;
  void add(const Span& other) {
    in = std::min(in, other.in);
    out = std::max(out, other.out);
  }
};

Span span_of_ball(const Vec3& w, const Vec3& n, double r) {
  // |t n - w| = r:  t = n.w -+ sqrt(r^2 - |w - (n.w) n|^2)
  const double b = n.dot(w);
  const double square = r * r - (w - b * n).squaredNorm();
  if (square < 0) return {};
  const double half = std::sqrt(square);
  return {b - half, b + half};
}

/// A ball whose centre goes from w0 to w1 (both from the ray's p).
Span span_of_capsule(const Vec3& w0, const Vec3& w1, const Vec3& n, double r) {
  Span span = span_of_ball(w0, n, r);
  span.add(span_of_ball(w1, n, r));
  const Vec3 way = w1 - w0;
  const double length = way.norm();
  if (length == 0) return span;
  const Vec3 d = way / length;
  const double along = n.dot(d);
  const Vec3 across = n - along * d, v = w0 - w0.dot(d) * d;
  const double a = across.squaredNorm();
  if (a < 1e-14) return span;
  // |t across - v|^2 = r^2, and the foot on the way: 0 <= t along - w0.d <= length
  const double b = across.dot(v) / a;
  const double square = r * r / a - (v - b * across).squaredNorm() / a;
  if (square < 0) return span;
  const double half = std::sqrt(square);
  for (const double t : {b - half, b + half}) {
    const double foot = t * along - w0.dot(d);
    if (foot >= 0 && foot <= length) span.add({t, t});
  }
  return span;
}

std::optional<double> first_of(const Span& span, const Ray& ray) {
  if (span.in > ray.high || span.out < ray.low) return std::nullopt;
  return std::max(span.in, ray.low);
}

/// f, its slope along the piece and along the ray.
struct Slopes {
  double value = 0, along_piece = 0, along_ray = 0;
};

Slopes slopes_at(const Cutter& cutter, const SweepPiece& piece, const Ray& ray, double s, double t) {
  const Vec3 way = piece.to.tip - piece.from.tip, swing = piece.to.axis - piece.from.axis;
  const Vec3 lean = piece.from.axis + s * swing;
  const double size = lean.norm();
  const Vec3 axis = lean / size, turn = (swing - axis.dot(swing) * axis) / size;
  const Vec3 x = ray.p + t * ray.n - piece.from.tip - s * way;
  const double h = x.dot(axis);
  const Vec3 out = x - h * axis;
  const double rho = out.norm();
  const CutterDistance f = cutter_distance(cutter, piece.worn, h, rho);
  const Vec3 radial = rho > 0 ? Vec3(out / rho) : Vec3::Zero();
  // h' = -way.a + x.a',  rho' = -way.e - h a'.e
  const double h_slope = x.dot(turn) - way.dot(axis), rho_slope = -way.dot(radial) - h * turn.dot(radial);
  return {f.value, f.along * h_slope + f.across * rho_slope,
          f.along * ray.n.dot(axis) + f.across * ray.n.dot(radial)};
}

/// m(t): the least distance along the piece, where f' changes its sign (Illinois).
Slopes least_at(const Cutter& cutter, const SweepPiece& piece, const Ray& ray, double t) {
  Slopes low = slopes_at(cutter, piece, ray, 0, t);
  if (low.along_piece >= 0) return low;
  Slopes high = slopes_at(cutter, piece, ray, 1, t);
  if (high.along_piece <= 0) return high;
  double a = 0, b = 1, fa = low.along_piece, fb = high.along_piece;
  int side = 0;
  for (int i = 0; i < kMostSteps && b - a > kNarrow; ++i) {
    // A kink of f stalls the secant: every fourth step halves.
    double s = i % 4 == 3 ? (a + b) / 2 : (a * fb - b * fa) / (fb - fa);
    if (!(s > a && s < b)) s = (a + b) / 2;
    const Slopes at = slopes_at(cutter, piece, ray, s, t);
    if (at.along_piece == 0) return at;
    const bool left = at.along_piece < 0;
    if (left)
      a = s, fa = at.along_piece, low = at;
    else
      b = s, fb = at.along_piece, high = at;
    if (side == (left ? -1 : 1)) (left ? fb : fa) /= 2;
    side = left ? -1 : 1;
  }
  return low.value < high.value ? low : high;
}

/// Does the shank come near the ray at all? Where not, a ball is all there is.
bool shank_is_near(const Cutter& cutter, const SweepPiece& piece, const Ray& ray) {
  for (const ToolPose* pose : {&piece.from, &piece.to}) {
    const double h = (ray.p - pose->tip).dot(pose->axis), rise = ray.n.dot(pose->axis);
    if (std::max(h + ray.low * rise, h + ray.high * rise) > cutter.corner) return true;
  }
  return false;
}

}  // namespace

std::optional<double> entry_of_any(const Cutter& cutter, const SweepPiece& piece, const Ray& ray) {
  double t = ray.low;
  for (int i = 0; i < kMostSteps; ++i) {
    const Slopes m = least_at(cutter, piece, ray, t);
    if (m.value <= kOnIt) return t;
    // |m'| <= 1, so the root is at least m away.
    if (t + m.value > ray.high || m.along_ray >= -kOnIt) return std::nullopt;
    t -= m.value / m.along_ray;
    if (t > ray.high) return std::nullopt;
  }
  return t;
}

std::optional<double> entry_of(const Cutter& cutter, const SweepPiece& piece, const Ray& ray) {
  if (!cutter.is_ball()) return entry_of_any(cutter, piece, ray);
  const double r = cutter.radius - piece.worn;
  if (r <= 0) return std::nullopt;
  const Vec3 w0 = piece.from.tip + cutter.radius * piece.from.axis - ray.p;
  const Vec3 w1 = piece.to.tip + cutter.radius * piece.to.axis - ray.p;
  const std::optional<double> ball = first_of(span_of_capsule(w0, w1, ray.n, r), ray);
  // Only below the ball's own entry can the shank say more.
  const Ray rest{ray.p, ray.n, ray.low, ball.value_or(ray.high)};
  if (rest.high <= rest.low || !shank_is_near(cutter, piece, rest)) return ball;
  const std::optional<double> whole = entry_of_any(cutter, piece, rest);
  return whole ? whole : ball;
}

}  // namespace abbe
