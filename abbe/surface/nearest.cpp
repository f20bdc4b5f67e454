#include "abbe/surface/nearest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace abbe {
namespace {

constexpr int kMostSteps = 40;
constexpr double kAskew = 1e-3;  // rad between point and normal: half its square of the deviation is nothing
constexpr double kTiny = 1e-9;   // mm
constexpr std::size_t kStarts = 3;
constexpr std::size_t kMostSamples = 400;  // per direction: large nets have close samples anyway

/// Half the square of the distance, its slope and its bend in (u, v).
struct Valley {
  double value = 0;
  std::array<double, 2> slope{};
  std::array<double, 3> bend{};  ///< uu uv vv
};

Valley valley_at(const SurfacePoint& s, const Vec3& point) {
  const Vec3 r = s.p - point;
  // g = r.r / 2;  g_u = r.S_u;  g_uv = S_u.S_v + r.S_uv
  return {r.squaredNorm() / 2,
          {r.dot(s.u), r.dot(s.v)},
          {s.u.dot(s.u) + r.dot(s.uu), s.u.dot(s.v) + r.dot(s.uv), s.v.dot(s.v) + r.dot(s.vv)}};
}

/// Newton's step; where the valley is a saddle, the step of Gauss and Newton; directions at their end stand
/// still.
std::array<double, 2> step_of(const Valley& g, const SurfacePoint& s, const std::array<bool, 2>& held) {
  double a = g.bend[0], b = g.bend[1], c = g.bend[2];
  if (held[0] || held[1]) b = 0;
  const double uu = s.u.dot(s.u), uv = held[0] || held[1] ? 0 : s.u.dot(s.v), vv = s.v.dot(s.v);
  const bool good =
      (held[0] || a > 1e-3 * uu) && (held[1] || c > 1e-3 * vv) && a * c - b * b > 1e-6 * std::abs(a * c);
  if (!good) a = uu, b = uv, c = vv;
  const double du = held[0] ? 0 : -g.slope[0], dv = held[1] ? 0 : -g.slope[1];
  if (held[0]) return {0, c > 0 ? dv / c : 0};
  if (held[1]) return {a > 0 ? du / a : 0, 0};
  const double det = a * c - b * b;
  if (!(det > 0)) return {a > 0 ? du / a : 0, c > 0 ? dv / c : 0};
  return {(c * du - b * dv) / det, (a * dv - b * du) / det};
}

SurfaceFoot foot_at(SurfacePlace place, const SurfacePoint& s, const Vec3& point, bool on_rim) {
  SurfaceFoot foot;
  foot.place = place;
  foot.at = s;
  const Vec3 off = point - s.p;
  foot.deviation = off.dot(s.normal);
  foot.distance = off.norm();
  foot.on_rim = on_rim;
  foot.is_normal =
      s.is_regular() && (off - foot.deviation * s.normal).norm() <= kAskew * foot.distance + kTiny;
  if (!foot.is_normal && !on_rim && s.is_regular())
    foot.deviation = std::copysign(foot.distance, foot.deviation);
  return foot;
}

}  // namespace

std::vector<double> span_samples(const NurbsSurface& surface, std::size_t direction, std::size_t pieces) {
  const std::vector<double>& knots = surface.knots[direction];
  std::vector<double> out;
  for (auto i = static_cast<std::size_t>(surface.degree[direction]); i < surface.count[direction]; ++i) {
    if (!(knots[i] < knots[i + 1])) continue;
    for (std::size_t k = 0; k < pieces; ++k)
      out.push_back(knots[i] +
                    (knots[i + 1] - knots[i]) * static_cast<double>(k) / static_cast<double>(pieces));
  }
  out.push_back(surface.range(direction)[1]);
  return out;
}

NearestPoint::NearestPoint(NurbsSurface surface) : surface_(std::move(surface)) {
  std::array<std::vector<double>, 2> at;
  for (std::size_t d = 0; d < 2; ++d) {
    at[d] = span_samples(surface_, d, kSamples);
    if (at[d].size() > kMostSamples) at[d] = span_samples(surface_, d, 1);
  }
  for (const double u : at[0])
    for (const double v : at[1]) {
      places_.push_back({u, v});
      samples_.push_back(evaluate(surface_, places_.back()).p);
    }
}

SurfaceFoot NearestPoint::from(SurfacePlace start, const Vec3& point) const {
  const std::array<double, 2> ends[2] = {surface_.range(0), surface_.range(1)};
  std::array<double, 2> x{std::clamp(start.u, ends[0][0], ends[0][1]),
                          std::clamp(start.v, ends[1][0], ends[1][1])};
  SurfacePoint s = evaluate(surface_, {x[0], x[1]});
  Valley g = valley_at(s, point);
  for (int i = 0; i < kMostSteps; ++i) {
    std::array<bool, 2> held{};
    for (std::size_t d = 0; d < 2; ++d)
      held[d] = (x[d] <= ends[d][0] && g.slope[d] > 0) || (x[d] >= ends[d][1] && g.slope[d] < 0);
    if (held[0] && held[1]) break;
    const std::array<double, 2> step = step_of(g, s, held);
    bool better = false;
    double share = 1;
    for (int k = 0; k < 30 && !better; ++k, share /= 2) {
      std::array<double, 2> next;
      for (std::size_t d = 0; d < 2; ++d)
        next[d] = std::clamp(x[d] + share * step[d], ends[d][0], ends[d][1]);
      if (next == x) break;
      const SurfacePoint t = evaluate(surface_, {next[0], next[1]});
      const Valley h = valley_at(t, point);
      better = h.value < g.value;
      if (better) x = next, s = t, g = h;
    }
    if (!better) break;
  }
  const bool rim = x[0] <= ends[0][0] || x[0] >= ends[0][1] || x[1] <= ends[1][0] || x[1] >= ends[1][1];
  return foot_at({x[0], x[1]}, s, point, rim);
}

SurfaceFoot NearestPoint::operator()(const Vec3& point) const {
  std::array<std::pair<double, std::size_t>, kStarts> best;
  best.fill({std::numeric_limits<double>::infinity(), 0});
  if (!point.allFinite()) return foot_at(places_[0], evaluate(surface_, places_[0]), samples_[0], true);
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    std::pair<double, std::size_t> found{(samples_[i] - point).squaredNorm(), i};
    for (auto& known : best)
      if (found.first < known.first) std::swap(found, known);
  }
  SurfaceFoot foot = from(places_[best[0].second], point);
  for (std::size_t k = 1; k < kStarts; ++k) {
    if (!std::isfinite(best[k].first)) break;
    const SurfaceFoot other = from(places_[best[k].second], point);
    if (other.distance < foot.distance) foot = other;
  }
  return foot;
}

}  // namespace abbe
