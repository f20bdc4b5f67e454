#pragma once

#include <optional>
#include <span>

namespace abbe {

/// deviation = offset + slope * position
struct ReferenceLine {
  double offset = 0, slope = 0;
};

/// A straightness value: largest minus smallest distance from its reference line, over the measured range.
struct Straightness {
  ReferenceLine line;
  double value = 0;
};

/// Straightness about the three reference lines in use. They differ, so a value without its line says little.
struct StraightnessFigures {
  Straightness end_points;     ///< line through the first and the last point
  Straightness least_squares;  ///< line of the least sum of squares
  Straightness
      minimum_zone;  ///< line of the least value: two points on one side, one between them on the other
};

/// positions: strictly increasing; deviations: as many, at least two; both finite.
/// units    value and offset like deviations, slope in deviation per position
/// errors   nullopt if the rules above are broken
/// laws     PublishedExample, MinimumZoneIsTheLeast, TrendsDoNotCount
/// cost     O(n) and O(h^2) for h corners of the convex hull
/// source   ISO 230-1:2012 manner; docs/theory/measurement.md
[[nodiscard]] std::optional<StraightnessFigures> straightness_figures(std::span<const double> positions,
                                                                      std::span<const double> deviations);

/// The line of the least sum of squares alone; the same rules.
[[nodiscard]] std::optional<ReferenceLine> least_squares_line(std::span<const double> positions,
                                                              std::span<const double> deviations);

}  // namespace abbe
