#include "abbe/compensate/nurbs_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace abbe {
namespace {

constexpr int kMostOrder = 8;
constexpr int kMostSteps = 80;
constexpr double kNanometre = 1e-6;  // mm

}  // namespace

std::string fault_of(const NurbsCurve& curve) {
  const auto order = static_cast<std::size_t>(std::max(0, curve.order));
  const std::vector<double>& t = curve.knots;
  if (curve.order < 2 || curve.order > kMostOrder) return fmt::format("its order is {}", curve.order);
  if (curve.points.size() < order)
    return fmt::format("{} control points are too few for order {}", curve.points.size(), order);
  if (t.size() != curve.points.size() + order)
    return fmt::format("{} knots for {} control points of order {}", t.size(), curve.points.size(), order);
  for (std::size_t i = 0; i + 1 < t.size(); ++i)
    if (!(t[i] <= t[i + 1])) return "its knots decrease";
  if (t[0] != t[order - 1] || t[t.size() - order] != t.back() || !(t[0] < t.back()))
    return "it does not begin and end at its control points: the first knots, as many as the order, must be "
           "equal, and the last ones";
  if (!std::all_of(curve.weights.begin(), curve.weights.end(), [](double w) { return w > 0; }))
    return "a weight is not above zero";
  return {};
}

Vec3 place_on(const NurbsCurve& curve, double u) {
  const auto p = static_cast<std::size_t>(curve.order - 1);
  const std::vector<double>& t = curve.knots;
  // the span t_k <= u < t_{k+1}, the last one closed
  const auto last = t.begin() + static_cast<std::ptrdiff_t>(curve.points.size());
  const auto behind = std::upper_bound(t.begin() + static_cast<std::ptrdiff_t>(p + 1), last, u);
  const auto k = static_cast<std::size_t>(behind - t.begin()) - 1;
  std::array<Eigen::Vector4d, kMostOrder> d;
  for (std::size_t j = 0; j <= p; ++j) {
    const std::size_t i = k - p + j;
    d[j] << curve.weights[i] * curve.points[i], curve.weights[i];
  }
  // d_j := (1 - a) d_{j-1} + a d_j,  a = (u - t_i) / (t_{i+p+1-r} - t_i)
  for (std::size_t r = 1; r <= p; ++r) {
    for (std::size_t j = p; j >= r; --j) {
      const std::size_t i = k - p + j;
      const double width = t[i + p + 1 - r] - t[i];
      const double a = width > 0 ? (u - t[i]) / width : 0;
      d[j] = (1 - a) * d[j - 1] + a * d[j];
    }
  }
  return d[p].head<3>() / d[p][3];
}

double greville(const NurbsCurve& curve, std::size_t i) {
  const auto p = static_cast<std::size_t>(curve.order - 1);
  const auto first = curve.knots.begin() + static_cast<std::ptrdiff_t>(i + 1);
  return std::accumulate(first, first + static_cast<std::ptrdiff_t>(p), 0.0) / static_cast<double>(p);
}

std::vector<Vec3> shifts_through(const NurbsCurve& curve, const std::vector<Vec3>& wanted) {
  NurbsCurve moving = curve;
  moving.points = wanted;
  std::vector<Vec3> missing(wanted.size());
  for (int step = 0; step < kMostSteps; ++step) {
    double most = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      missing[i] = wanted[i] - place_on(moving, greville(curve, i));
      most = std::max(most, missing[i].cwiseAbs().maxCoeff());
    }
    if (!(most > kNanometre)) break;
    for (std::size_t i = 0; i < wanted.size(); ++i) moving.points[i] += missing[i];
  }
  return moving.points;
}

}  // namespace abbe
