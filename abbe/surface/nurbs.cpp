#include "abbe/surface/nurbs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr std::size_t kMaxOrder = NurbsSurface::kMaxDegree + 1;

/// The basis functions that are not zero at a parameter, and their first two derivatives.
struct Basis {
  std::size_t first = 0;                              ///< index of the first of them
  std::array<std::array<double, kMaxOrder>, 3> of{};  ///< [derivative][function]
};

/// The last span that begins at or before x: knots[span] <= x < knots[span + 1], the end belongs to the last
/// one.
std::size_t span_of(const std::vector<double>& knots, std::size_t count, std::size_t degree, double x) {
  const auto begin = knots.begin() + static_cast<std::ptrdiff_t>(degree);
  const auto end = knots.begin() + static_cast<std::ptrdiff_t>(count);
  auto at = static_cast<std::size_t>(std::upper_bound(begin, end, x) - knots.begin()) - 1;
  while (at > degree && !(knots[at] < knots[at + 1])) --at;  // the last knots of the range may be equal
  return at;
}

using Triangle = std::array<std::array<double, kMaxOrder>, kMaxOrder>;

/// ndu of A2.3: basis functions of all degrees above the diagonal, knot differences below.
Triangle triangle_of(const std::vector<double>& knots, std::size_t span, std::size_t p, double x) {
  Triangle ndu{};
  std::array<double, kMaxOrder> left{}, right{};
  ndu[0][0] = 1;
  for (std::size_t j = 1; j <= p; ++j) {
    left[j] = x - knots[span + 1 - j];
    right[j] = knots[span + j] - x;
    double saved = 0;
    for (std::size_t r = 0; r < j; ++r) {
      // N_{i,p} = (x - t_i) / (t_{i+p} - t_i) N_{i,p-1} + (t_{i+p+1} - x) / (t_{i+p+1} - t_{i+1}) N_{i+1,p-1}
      ndu[j][r] = right[r + 1] + left[j - r];
      const double share = ndu[r][j - 1] / ndu[j][r];
      ndu[r][j] = saved + right[r + 1] * share;
      saved = left[j - r] * share;
    }
    ndu[j][j] = saved;
  }
  return ndu;
}

Basis basis_at(const std::vector<double>& knots, std::size_t count, int degree, double x) {
  const auto p = static_cast<std::size_t>(degree);
  const std::size_t span = span_of(knots, count, p, x);
  const Triangle ndu = triangle_of(knots, span, p, x);
  Basis basis;
  basis.first = span - p;
  for (std::size_t r = 0; r <= p; ++r) basis.of[0][r] = ndu[r][p];
  // N' = p (N_{i,p-1} / (t_{i+p} - t_i) - N_{i+1,p-1} / (t_{i+p+1} - t_{i+1})), and so again
  const auto below = [&](std::size_t r, std::size_t q) {  // N_{r,q} / its knot difference, 0 outside
    return r <= q ? ndu[r][q] / ndu[q + 1][r] : 0.0;
  };
  for (std::size_t r = 0; r <= p; ++r) {
    const double minus = r > 0 ? below(r - 1, p - 1) : 0.0;
    basis.of[1][r] = static_cast<double>(p) * (minus - below(r, p - 1));
    if (p < 2) continue;
    double second = 0;
    for (const int side : {-1, 0}) {
      // the derivative of N_{k,p-1}, k = r - 1 and r, by the same rule
      const std::ptrdiff_t k = static_cast<std::ptrdiff_t>(r) + side;
      if (k < 0 || k > static_cast<std::ptrdiff_t>(p) - 1) continue;
      const auto i = static_cast<std::size_t>(k);
      const double slope = (i > 0 ? below(i - 1, p - 2) : 0.0) - below(i, p - 2);
      second += (side < 0 ? 1.0 : -1.0) * slope / ndu[p][i];
    }
    basis.of[2][r] = static_cast<double>(p * (p - 1)) * second;
  }
  return basis;
}

/// Homogeneous derivative sum: A = sum N w P and its weight.
struct Weighted {
  Vec3 A = Vec3::Zero();
  double w = 0;
};

Weighted sum_of(const NurbsSurface& surface, const Basis& bu, const Basis& bv, std::size_t ku,
                std::size_t kv) {
  Weighted sum;
  for (int i = 0; i <= surface.degree[0]; ++i) {
    const auto r = static_cast<std::size_t>(i);
    const std::size_t row = (bu.first + r) * surface.count[1] + bv.first;
    for (int j = 0; j <= surface.degree[1]; ++j) {
      const auto c = static_cast<std::size_t>(j);
      const double weight = bu.of[ku][r] * bv.of[kv][c] * surface.weights[row + c];
      sum.A += weight * surface.points[row + c];
      sum.w += weight;
    }
  }
  return sum;
}

/// What grows from nothing beside a pole: +1 at the lower end of the range, -1 at the upper one, 0 inside.
double side_of(const std::array<double, 2>& range, double x) {
  return x <= range[0] ? 1 : x >= range[1] ? -1 : 0;
}

/// S_u x S_v, at a pole its direction in the limit.
Vec3 across_of(const NurbsSurface& surface, const SurfacePlace& place, const SurfacePoint& s) {
  if (!s.is_pole()) return s.u.cross(s.v);
  // S_v = (u - u_0) S_uv,  S_u = (v - v_0) S_uv
  if (s.v.squaredNorm() < s.u.squaredNorm()) return side_of(surface.range(0), place.u) * s.u.cross(s.uv);
  return side_of(surface.range(1), place.v) * s.uv.cross(s.v);
}

bool are_knots(const std::vector<double>& knots, std::size_t count, int degree) {
  const auto p = static_cast<std::size_t>(degree);
  if (knots.size() != count + p + 1) return false;
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (!std::isfinite(knots[i]) || (i > 0 && knots[i] < knots[i - 1])) return false;
    // A knot that is met more than degree times inside tears the surface apart.
    if (i > p && i + p + 1 < knots.size() && !(knots[i] < knots[i + p])) return false;
  }
  return knots[p] < knots[count] && std::isfinite(knots[count] - knots[p]);
}

}  // namespace

bool NurbsSurface::is_valid() const {
  for (std::size_t d = 0; d < 2; ++d) {
    if (degree[d] < 1 || degree[d] > kMaxDegree || count[d] > kMaxPoints) return false;
    if (count[d] < static_cast<std::size_t>(degree[d]) + 1) return false;
    if (!are_knots(knots[d], count[d], degree[d])) return false;
  }
  const auto fits = [](const Vec3& p) { return p.allFinite() && p.cwiseAbs().maxCoeff() <= kLongest; };
  const auto weighs = [](double w) { return w >= 1e-6 && w <= 1e6; };
  return points.size() == count[0] * count[1] && points.size() <= kMaxPoints &&
         weights.size() == points.size() && std::all_of(points.begin(), points.end(), fits) &&
         std::all_of(weights.begin(), weights.end(), weighs) && std::abs(outward) == 1;
}

std::vector<double> uniform_knots(std::size_t count, int degree) {
  const auto p = static_cast<std::size_t>(degree);
  std::vector<double> knots(count + p + 1, 0.0);
  for (std::size_t i = p; i < knots.size(); ++i)
    knots[i] = static_cast<double>(std::min(i, count) - p) / static_cast<double>(count - p);
  return knots;
}

SurfacePoint evaluate(const NurbsSurface& surface, SurfacePlace place) {
  const auto [ulo, uhi] = surface.range(0);
  const auto [vlo, vhi] = surface.range(1);
  const Basis bu =
      basis_at(surface.knots[0], surface.count[0], surface.degree[0], std::clamp(place.u, ulo, uhi));
  const Basis bv =
      basis_at(surface.knots[1], surface.count[1], surface.degree[1], std::clamp(place.v, vlo, vhi));
  const Weighted s = sum_of(surface, bu, bv, 0, 0);
  const Weighted u = sum_of(surface, bu, bv, 1, 0), v = sum_of(surface, bu, bv, 0, 1);
  const Weighted uu = sum_of(surface, bu, bv, 2, 0), uv = sum_of(surface, bu, bv, 1, 1),
                 vv = sum_of(surface, bu, bv, 0, 2);
  SurfacePoint out;
  // S = A / w;  S_u = (A_u - w_u S) / w;  S_uv = (A_uv - w_u S_v - w_v S_u - w_uv S) / w
  out.p = s.A / s.w;
  out.u = (u.A - u.w * out.p) / s.w;
  out.v = (v.A - v.w * out.p) / s.w;
  out.uu = (uu.A - 2 * u.w * out.u - uu.w * out.p) / s.w;
  out.uv = (uv.A - u.w * out.v - v.w * out.u - uv.w * out.p) / s.w;
  out.vv = (vv.A - 2 * v.w * out.v - vv.w * out.p) / s.w;
  const Vec3 across = across_of(surface, place, out);
  const double length = across.norm();
  // Parallel within rounding is parallel.
  const double sides =
      out.is_pole() ? std::max(out.u.norm(), out.v.norm()) * out.uv.norm() : out.u.norm() * out.v.norm();
  if (length > 1e-12 * sides && length > 0) out.normal = surface.outward / length * across;
  return out;
}

Curvature curvature_at(const SurfacePoint& point) {
  if (!point.is_regular()) return {};
  const double E = point.u.dot(point.u), F = point.u.dot(point.v), G = point.v.dot(point.v);
  const double L = point.uu.dot(point.normal), M = point.uv.dot(point.normal), N = point.vv.dot(point.normal);
  // H = (E N - 2 F M + G L) / (2 (E G - F^2)),  K = (L N - M^2) / (E G - F^2),  k = H -+ sqrt(H^2 - K)
  const double area = E * G - F * F;
  const double H = (E * N - 2 * F * M + G * L) / (2 * area), K = (L * N - M * M) / area;
  if (!std::isfinite(H) || !std::isfinite(K)) return {};
  const double half = std::sqrt(std::max(0.0, H * H - K));
  return {H - half, H + half};
}

double curvature_along(const SurfacePoint& point, const Vec3& tangent) {
  if (!point.is_regular()) return 0;
  const double E = point.u.dot(point.u), F = point.u.dot(point.v), G = point.v.dot(point.v);
  const double area = E * G - F * F;
  // tangent = a S_u + b S_v
  const double tu = tangent.dot(point.u), tv = tangent.dot(point.v);
  const double a = (G * tu - F * tv) / area, b = (E * tv - F * tu) / area;
  const double first = E * a * a + 2 * F * a * b + G * b * b;
  const Vec3 bend = a * a * point.uu + 2 * a * b * point.uv + b * b * point.vv;
  const double k = bend.dot(point.normal) / first;
  return first > 0 && std::isfinite(k) ? k : 0;
}

std::vector<SurfacePlace> cell_places(const NurbsSurface& surface, std::size_t rows, std::size_t columns) {
  const auto [ulo, uhi] = surface.range(0);
  const auto [vlo, vhi] = surface.range(1);
  std::vector<SurfacePlace> places;
  places.reserve(rows * columns);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j)
      places.push_back({ulo + (uhi - ulo) * (static_cast<double>(i) + 0.5) / static_cast<double>(rows),
                        vlo + (vhi - vlo) * (static_cast<double>(j) + 0.5) / static_cast<double>(columns)});
  return places;
}

}  // namespace abbe
