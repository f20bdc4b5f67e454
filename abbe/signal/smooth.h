#pragma once

#include <span>

#include "abbe/signal/result.h"

namespace abbe {

/// Five-point cubic smoothing: every sample becomes the value there of the cubic that fits its five
/// neighbours best; the two samples at each end take the cubic of the first or last five.
///
///   y_i' = (-3 y_{i-2} + 12 y_{i-1} + 17 y_i + 12 y_{i+1} - 3 y_{i+2}) / 35
///   y_0' = (69 y_0 + 4 y_1 - 6 y_2 + 4 y_3 - y_4) / 70
///   y_1' = (2 y_0 + 27 y_1 + 12 y_2 - 8 y_3 + 2 y_4) / 35,   mirrored at the end
///
/// y        at least 5 samples
/// passes   how often, 0 to 10000
/// laws     cubics are left as they are (CubicsPass); it is savitzky_golay(y, 5, 3) (IsSavitzkyGolay)
/// cost     5 products per sample and pass
[[nodiscard]] SignalResult<Samples> five_point_smooth(std::span<const double> y, int passes = 1);

/// A polynomial of degree `order` fitted by least squares to every window of samples, evaluated, or
/// differentiated, at the middle of the window; the first and last half window take the polynomial of the
/// first and last full window.
struct SavitzkyGolay {
  int window = 11;     ///< samples, odd, 1 to 1001, not more than there are
  int order = 3;       ///< 0 to 10, less than window
  int derivative = 0;  ///< 0 to order
  double spacing = 1;  ///< s between samples, > 0: the derivative is per s^derivative
};

/// laws     polynomials up to `order` are exact, with their derivatives (PolynomialsAreExact)
/// cost     window products per sample
/// source   Savitzky, Golay, Analytical Chemistry 36 (1964) 1627
[[nodiscard]] SignalResult<Samples> savitzky_golay(std::span<const double> y, const SavitzkyGolay& options);

}  // namespace abbe
