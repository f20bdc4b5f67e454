// Curves by control points: both are evaluated at the same places of their knots.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/core/units.h"
#include "abbe/verify/comparison.h"

namespace abbe::verifying {
namespace {

constexpr double kInterval = 0.7;  // mm of the control polygon
constexpr int kFewest = 11, kMost = 3000;

double polygon_length(const Nurbs& nurbs) {
  double length = 0;
  for (std::size_t i = 1; i < nurbs.points.size(); ++i)
    length += (nurbs.points[i] - nurbs.points[i - 1]).norm();
  return length;
}

}  // namespace

void Comparison::compare_nurbs(const Motion& original, const Motion& output) {
  ++report_.feed_motions;
  withheld_ &= ~commanded(original);
  reached_.valid = false;
  const Nurbs &a = *original.nurbs, &b = *output.nurbs;
  if (withheld_ != 0) return disagree_and_stop("V-END", "a curve while an axis stands where G53 put it");
  if (a.order != b.order || a.knots != b.knots || a.weights != b.weights)
    return disagree_and_stop("V-PATH", "order, knots and weights of a curve must stay as they are");
  sample_nurbs(original, output);
  follow(a.points.back() - a.points[a.points.size() - 2]);
  check_reach(original.end.at, output.end.at);
}

/// In every span of knots, as often as its share of the control polygon asks for.
void Comparison::sample_nurbs(const Motion& original, const Motion& output) {
  const Nurbs &a = *original.nurbs, &b = *output.nurbs;
  const double length = polygon_length(a), allowed = allowed_for(quantum()), first = travelled_;
  const double range = a.knots.back() - a.knots.front();
  double worst = 0, worst_at = 0, beyond_at = 0;
  bool outside = false;
  int beyond = -1;
  for (std::size_t k = 0; k + 1 < a.knots.size(); ++k) {
    const double width = a.knots[k + 1] - a.knots[k];
    if (!(width > 0)) continue;
    const int n = std::clamp(static_cast<int>(std::ceil(length / kInterval * width / range)), kFewest, kMost);
    for (int i = 0; i <= n; ++i) {
      const double u = i == n ? a.knots[k + 1] : a.knots[k] + width * i / n;
      const Vec3 m = point_of(a, u), command = point_of(b, u);
      const Vec3 wanted = model_.nominal(m) + datum_;
      const Vec3 after = model_.actual(command, approach_, &outside) - wanted;
      const double s = (u - a.knots.front()) / range;
      if (!(after.norm() <= worst)) {
        worst = after.norm();
        worst_at = s;
      }
      if (beyond < 0) beyond = model_.beyond_travel(command, &beyond_at);
      travelled_ = first + s * length;
      const Vec3 before = model_.actual(m, approach_, nullptr) - wanted;
      before_.add(before, length * width / range / (n + 1), original_.line());
      after_.add(after, length * width / range / (n + 1), original_.line());
      ++report_.points;
      if (samples_.wants_next())
        keep_sample(wanted - datum_, before, after, false);
      else
        samples_.skip();
    }
  }
  if (!(worst <= allowed))
    disagree("V-PATH",
             fmt::format("the curve is {:.3f} um off at {:.1f} % of its knots, {:.3f} um are allowed",
                         worst / um, 100 * worst_at, allowed / um));
  if (outside) disagree("V-VOL", "this curve leaves the volume in which the errors are known");
  if (beyond >= 0) disagree("V-TRAVEL", travel_message(beyond, beyond_at));
}

}  // namespace abbe::verifying
