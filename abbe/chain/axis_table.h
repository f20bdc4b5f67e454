#pragma once

// Plain data: also read by code that is compiled for one instruction set (abbe/kernel).

#include <cstdint>
#include <limits>

namespace abbe {

/// Six error components, translations first: d X Y Z (mm), e about X Y Z (rad).
inline constexpr int kComponents = 6;

/// Everything in an error factor that depends on one axis position, tabulated: per segment a polynomial
/// for each of the six components, side by side, in mm or rad of internal units. Polynomials and tables
/// are in it exactly, sines to kTabulated. Rows of kComponents coefficients, highest power first, of the
/// distance from the segment's origin.
///
/// Segment i > 0 begins at its origin knots[i]; the first one reaches from there down to minus infinity
/// and the last one up to infinity, where functions are held at their ends or go on as what they are.
/// Sines go on only within [waves_lo, waves_hi]; beyond, they are added one by one.
struct AxisTable {
  int axis = 0;
  std::uint32_t rows = 1;  ///< degree + 1
  std::uint32_t segments = 1;
  std::uint32_t knots = 0;  ///< first of `segments` numbers in Impl::knots
  std::uint32_t data = 0;   ///< first coefficient in Impl::coefficients
  /// Of equally wide buckets from bucket_lo on: the segment at the lower end of each, in Impl::buckets.
  std::uint32_t first_bucket = 0, bucket_count = 1;
  double bucket_lo = 0, buckets_per_unit = 0;
  double lo = -std::numeric_limits<double>::infinity(), hi = std::numeric_limits<double>::infinity();
  bool bounded = false;              ///< beyond [lo, hi] some function is held at its end
  double period = 0, period_lo = 0;  ///< > 0: the position is taken into [period_lo, period_lo + period)
  double waves_lo = 0, waves_hi = 0;
  std::uint32_t first_wave = 0, wave_count = 0;
  /// 0: always. +1, -1: of the error in this direction of approach of an axis: counts fully if that is the
  /// direction, half if none is known, else not at all.
  std::int8_t direction = 0, direction_axis = 0;
};

/// How much a table counts for a direction of approach (-1, 0, +1).
[[nodiscard]] constexpr double weight_of(int direction, int approach) {
  return direction == 0 || approach == direction ? 1.0 : approach == 0 ? 0.5 : 0.0;
}

/// component += amplitude sin(frequency x + phase), x held in [lo, hi]; internal units.
struct Wave {
  int component = 0;
  double amplitude = 0, frequency = 0, phase = 0;
  double lo = -std::numeric_limits<double>::infinity(), hi = std::numeric_limits<double>::infinity();
};

}  // namespace abbe
