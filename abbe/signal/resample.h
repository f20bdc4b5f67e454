#pragma once

#include <span>

#include "abbe/signal/result.h"

namespace abbe {

enum class Interpolation {
  linear,  ///< the line through the two neighbours
  cubic,   ///< the cubic through the four nearest; a line or parabola if there are only two or three
};

/// The record y over x at the places `at`, inside [x_0, x_{n-1}]: nothing is extrapolated.
///
/// x        strictly increasing (times in s, angles in rad, sample numbers), at least 2
/// at       in any order; no_overlap if one is outside
/// laws     at = x gives y (NodesAreKept); cubics are exact with `cubic` (CubicsAreExact)
/// cost     O(log n) per place, O(1) where `at` increases
[[nodiscard]] SignalResult<Samples> interpolate(std::span<const double> x, std::span<const double> y,
                                                std::span<const double> at, Interpolation kind);

/// A record on a grid of its own: first, first + spacing, .. up to the last time of x.
struct UniformRecord {
  double first = 0, spacing = 0;  ///< s
  Samples samples;
};

/// No filter is applied: what is faster than half the new rate must have been filtered out before.
/// spacing  s, > 0; at most 1e8 samples
[[nodiscard]] SignalResult<UniformRecord> resample(std::span<const double> x, std::span<const double> y,
                                                   double spacing, Interpolation kind = Interpolation::cubic);

}  // namespace abbe
