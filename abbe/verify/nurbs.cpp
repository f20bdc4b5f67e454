#include "abbe/verify/nurbs.h"

#include <algorithm>
#include <cstddef>

namespace abbe::verifying {
namespace {

constexpr int kHighestOrder = 8;

/// N_{i,n}(u) of order n:
///   N_{i,1} = 1 where t_i <= u < t_{i+1}
///   N_{i,n} = (u - t_i) / (t_{i+n-1} - t_i) N_{i,n-1} + (t_{i+n} - u) / (t_{i+n} - t_{i+1}) N_{i+1,n-1}
double basis(const std::vector<double>& t, std::size_t i, std::size_t n, double u) {
  if (u < t[i] || u > t[i + n]) return 0;
  if (n == 1) {
    const bool ends_here = u == t.back() && t[i + 1] == t.back() && t[i] < t[i + 1];
    return (t[i] <= u && u < t[i + 1]) || ends_here ? 1 : 0;
  }
  const double rising = t[i + n - 1] - t[i], falling = t[i + n] - t[i + 1];
  double sum = 0;
  if (rising > 0) sum += (u - t[i]) / rising * basis(t, i, n - 1, u);
  if (falling > 0) sum += (t[i + n] - u) / falling * basis(t, i + 1, n - 1, u);
  return sum;
}

}  // namespace

bool is_curve(const Nurbs& nurbs) {
  const std::vector<double>& t = nurbs.knots;
  if (nurbs.order < 2 || nurbs.order > kHighestOrder) return false;
  const auto order = static_cast<std::size_t>(nurbs.order);
  if (nurbs.points.size() < order || t.size() != nurbs.points.size() + order ||
      nurbs.weights.size() != nurbs.points.size())
    return false;
  for (std::size_t i = 0; i + 1 < t.size(); ++i)
    if (!(t[i] <= t[i + 1])) return false;
  for (const double weight : nurbs.weights)
    if (!(weight > 0)) return false;
  return t.front() == t[order - 1] && t[nurbs.points.size()] == t.back() && t.front() < t.back();
}

Vec3 point_of(const Nurbs& nurbs, double u) {
  Vec3 sum = Vec3::Zero();
  double whole = 0;
  const auto order = static_cast<std::size_t>(nurbs.order);
  // Only the points whose knots lie about u have a share: i < first knot above u, and u <= knots[i + order].
  const auto& t = nurbs.knots;
  const auto above = static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), u) - t.begin());
  const auto from = static_cast<std::size_t>(std::lower_bound(t.begin(), t.end(), u) - t.begin());
  const std::size_t first = from > order ? from - order : 0, last = std::min(above, nurbs.points.size());
  for (std::size_t i = first; i < last; ++i) {
    if (u < nurbs.knots[i] || u > nurbs.knots[i + order]) continue;
    const double share = basis(nurbs.knots, i, order, u) * nurbs.weights[i];
    sum += share * nurbs.points[i];
    whole += share;
  }
  return sum / whole;
}

}  // namespace abbe::verifying
