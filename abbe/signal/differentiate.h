#pragma once

#include <span>

#include "abbe/signal/result.h"

namespace abbe {

/// The derivative of equally spaced samples by differences of second order:
///
///   v_i = (y_{i+1} - y_{i-1}) / (2 dt)
///   v_0 = (-3 y_0 + 4 y_1 - y_2) / (2 dt),   v_{n-1} = (3 y_{n-1} - 4 y_{n-2} + y_{n-3}) / (2 dt)
///
/// y        at least 3 samples
/// dt       s between samples, > 0
/// laws     parabolas are exact (ParabolasAreExact)
[[nodiscard]] SignalResult<Samples> differentiate(std::span<const double> y, double dt);

}  // namespace abbe
