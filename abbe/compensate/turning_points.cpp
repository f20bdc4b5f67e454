#include "abbe/compensate/turning_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace abbe {

std::vector<double> turning_points(const Arc& arc, double rotation, double least) {
  constexpr double kQuarter = std::numbers::pi / 2;
  std::vector<double> places;
  const double turn = arc.plane == Plane::xy ? rotation : 0.0, from = arc.a0 + turn, rate = arc.r1 - arc.r0;
  // Beside its turning point an axis is displaced by r (sweep ds)^2 / 2.
  const double margin = std::sqrt(2 * least / std::min(arc.r0, arc.r1)) / std::abs(arc.sweep);
  const double lo = std::min(from, from + arc.sweep), hi = std::max(from, from + arc.sweep);
  const auto last = static_cast<long>(std::ceil(hi / kQuarter)) + 1;
  for (auto k = static_cast<long>(std::floor(lo / kQuarter)) - 1; k <= last; ++k) {
    double s = (static_cast<double>(k) * kQuarter - from) / arc.sweep;
    for (int i = 0; i < 3; ++i) {
      // the radius hardly changes along an arc that a control accepts, so putting s in again converges at
      // once
      const double radius = std::max(arc.r0 + std::clamp(s, 0.0, 1.0) * rate, std::min(arc.r0, arc.r1));
      s = (static_cast<double>(k) * kQuarter + std::atan(rate / (radius * arc.sweep)) - from) / arc.sweep;
    }
    if (s > margin && s < 1 - margin) places.push_back(s);
  }
  std::sort(places.begin(), places.end());
  return places;
}

}  // namespace abbe
