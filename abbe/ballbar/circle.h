#pragma once

#include <span>

namespace abbe {

/// A circle about which radial deviations are judged. Deviations about its centre:
///     r_i' = r_i - x cos theta_i - y sin theta_i        (first order in r / radius)
struct FittedCircle {
  double x = 0, y = 0;       ///< centre along the first and second axis of the plane, mm
  double mean = 0;           ///< of r', mm; of the minimum zone the middle of the zone
  double low = 0, high = 0;  ///< smallest and largest r', mm
  bool found = false;        ///< false: fewer than three different angles, or numbers that are not finite

  /// G: the radial width of the zone that holds all points.
  [[nodiscard]] double width() const { return high - low; }
};

/// r_i = mean + x cos theta_i + y sin theta_i with the least sum of squares.
[[nodiscard]] FittedCircle least_squares_circle(std::span<const double> angle,
                                                std::span<const double> deviation);

/// The centre of the narrowest concentric zone: least high - low with low <= r_i' <= high for all i. A linear
/// programme in four unknowns, solved exactly by exchanging one touching point at a time.
///
/// laws     MinimumZoneIsNoWiderThanAnyOther, FourPointsTouchInTurn
/// cost     O(n) per exchange, some tens of exchanges
/// source   docs/theory/ball-bar.md, section 2
[[nodiscard]] FittedCircle minimum_zone_circle(std::span<const double> angle,
                                               std::span<const double> deviation);

}  // namespace abbe
