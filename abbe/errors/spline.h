#pragma once

#include <span>
#include <vector>

namespace abbe {

/// Second derivatives M_i at the samples of the cubic spline through (x_i, e_i):
///
///   h_{i-1} M_{i-1} + 2 (h_{i-1} + h_i) M_i + h_i M_{i+1} = 6 (s_i - s_{i-1}),  h_i = x_{i+1} - x_i,
///   s_i = (e_{i+1} - e_i) / h_i
///
/// natural: M = 0 at both ends. Periodic: the last sample is the first one again, one period on, and
/// the equation holds there across the seam.
///
/// shapes   positions strictly increasing, n >= 2; values: n (periodic: the last equals the first)
/// cost     O(n)
/// source   docs/theory/error-functions.md (6) to (8)
[[nodiscard]] std::vector<double> natural_spline(std::span<const double> positions,
                                                 std::span<const double> values);
[[nodiscard]] std::vector<double> periodic_spline(std::span<const double> positions,
                                                  std::span<const double> values);

}  // namespace abbe
