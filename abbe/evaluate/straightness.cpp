#include "abbe/evaluate/straightness.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace abbe {
namespace {

using Span = std::span<const double>;

bool usable(Span x, Span y) {
  if (x.size() < 2 || x.size() != y.size()) return false;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!std::isfinite(x[i]) || !std::isfinite(y[i]) || (i > 0 && !(x[i] > x[i - 1]))) return false;
  return true;
}

Straightness about(Span x, Span y, ReferenceLine line) {
  double lo = 0, hi = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double distance = y[i] - line.offset - line.slope * x[i];
    lo = i == 0 ? distance : std::min(lo, distance);
    hi = i == 0 ? distance : std::max(hi, distance);
  }
  return {line, hi - lo};
}

ReferenceLine through(Span x, Span y, std::size_t a, std::size_t b) {
  const double slope = (y[b] - y[a]) / (x[b] - x[a]);
  return {y[a] - slope * x[a], slope};
}

/// Indices of the upper (side +1) or lower (side -1) convex hull, left to right.
std::vector<std::size_t> hull(Span x, Span y, double side) {
  std::vector<std::size_t> corners;
  for (std::size_t i = 0; i < x.size(); ++i) {
    while (corners.size() >= 2) {
      const std::size_t a = corners[corners.size() - 2], b = corners.back();
      // b is a corner only if the path a, b, i turns away from the side.
      const double turn = (x[b] - x[a]) * (y[i] - y[a]) - (y[b] - y[a]) * (x[i] - x[a]);
      if (side * turn < 0) break;
      corners.pop_back();
    }
    corners.push_back(i);
  }
  return corners;
}

/// The least zone has an edge of the hull on one side and a corner of the hull on the other.
ReferenceLine minimum_zone_line(Span x, Span y) {
  ReferenceLine best = through(x, y, 0, x.size() - 1);
  double least = about(x, y, best).value;
  for (const double side : {1.0, -1.0}) {
    const std::vector<std::size_t> edges = hull(x, y, side), others = hull(x, y, -side);
    for (std::size_t k = 1; k < edges.size(); ++k) {
      const ReferenceLine line = through(x, y, edges[k - 1], edges[k]);
      double depth = 0;
      for (const std::size_t i : others)
        depth = std::max(depth, side * (line.offset + line.slope * x[i] - y[i]));
      if (depth < least) {
        least = depth;
        best = line;
      }
    }
  }
  return best;
}

}  // namespace

std::optional<ReferenceLine> least_squares_line(Span positions, Span deviations) {
  if (!usable(positions, deviations)) return std::nullopt;
  const auto n = static_cast<double>(positions.size());
  double x_mean = 0, y_mean = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    x_mean += positions[i] / n;
    y_mean += deviations[i] / n;
  }
  // slope = sum (x - x_mean)(y - y_mean) / sum (x - x_mean)^2
  for (std::size_t i = 0; i < positions.size(); ++i) {
    xx += (positions[i] - x_mean) * (positions[i] - x_mean);
    xy += (positions[i] - x_mean) * (deviations[i] - y_mean);
  }
  const double slope = xy / xx;
  if (!std::isfinite(slope)) return std::nullopt;
  return ReferenceLine{y_mean - slope * x_mean, slope};
}

std::optional<StraightnessFigures> straightness_figures(Span positions, Span deviations) {
  const std::optional<ReferenceLine> line = least_squares_line(positions, deviations);
  if (!line) return std::nullopt;
  return StraightnessFigures{
      about(positions, deviations, through(positions, deviations, 0, positions.size() - 1)),
      about(positions, deviations, *line),
      about(positions, deviations, minimum_zone_line(positions, deviations))};
}

}  // namespace abbe
