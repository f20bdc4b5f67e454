#include "abbe/volume/grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace abbe {

std::size_t VolumeGrid::size() const {
  std::size_t product = positions.empty() ? 0 : 1;
  for (const std::vector<double>& axis : positions) {
    if (axis.empty() || product > std::numeric_limits<std::size_t>::max() / axis.size()) return 0;
    product *= axis.size();
  }
  return product;
}

std::array<double, kMaxAxes> VolumeGrid::at(std::size_t index) const {
  std::array<double, kMaxAxes> q{};
  for (std::size_t i = positions.size(); i-- > 0;) {
    q[i] = positions[i][index % positions[i].size()];
    index /= positions[i].size();
  }
  return q;
}

bool VolumeGrid::varies(int axis) const { return positions[static_cast<std::size_t>(axis)].size() > 1; }

std::optional<std::vector<double>> spaced(double lo, double hi, std::size_t count) {
  if (count == 0 || !std::isfinite(lo) || !std::isfinite(hi) || !std::isfinite(hi - lo)) return std::nullopt;
  if (count == 1 ? lo > hi : !(lo < hi)) return std::nullopt;
  if (count == 1) return std::vector<double>{lo + (hi - lo) / 2};
  std::vector<double> positions(count);
  const double steps = static_cast<double>(count - 1);
  for (std::size_t k = 0; k < count; ++k) {
    // Weighted ends: symmetric travels give symmetric positions, and their middle is exactly 0.
    const double part = static_cast<double>(k);
    positions[k] = (lo * (steps - part) + hi * part) / steps;
  }
  positions.front() = lo;
  positions.back() = hi;
  return positions;
}

std::size_t default_count(std::size_t varying) {
  constexpr std::array<std::size_t, 7> kCounts = {101, 101, 51, 21, 11, 7, 5};
  return varying < kCounts.size() ? kCounts[varying] : 3;
}

std::array<double, kMaxAxes> default_datum(const VolumeGrid& grid) {
  std::array<double, kMaxAxes> q{};
  for (std::size_t i = 0; i < grid.positions.size(); ++i) {
    const auto [lo, hi] = std::minmax_element(grid.positions[i].begin(), grid.positions[i].end());
    q[i] = std::clamp(0.0, *lo, *hi);
  }
  return q;
}

}  // namespace abbe
