#pragma once

#include <cstddef>
#include <span>

#include "abbe/signal/result.h"

namespace abbe {

/// How much later the same happens in a second record, from the largest correlation coefficient over the
/// part where both overlap:
///
///   r(l) = cov(a_i, b_{i+l}) / sqrt(var a var b),   delay = the l of the largest r, refined by a parabola
///
/// Records that repeat themselves have several peaks: of those within 1e-3 of the highest the smallest delay
/// counts. Ripples that noise puts on one peak are no peaks: between two r falls by 0.1 or more.
struct Delay {
  double samples = 0;      ///< > 0: b is behind a, b(t) is like a(t - delay)
  double coefficient = 0;  ///< r there, -1 to 1: close to 1 if the records really are alike
};

struct DelayOptions {
  std::size_t most =
      0;  ///< largest |l| looked at, in samples; 0: as far as half of the shorter record overlaps
  double least_overlap = 0.5;  ///< part of the shorter record that must overlap, 0 to 1
};

/// a, b     of the same sampling rate, at least 4 samples each; lengths may differ
/// laws     exchanging a and b changes the sign of the delay (ExchangeChangesTheSign)
/// cost     O((n + m) log (n + m))
[[nodiscard]] SignalResult<Delay> find_delay(std::span<const double> a, std::span<const double> b,
                                             const DelayOptions& options = {});

/// The angle of a point that goes round a centre, without jumps: atan2(y - cy, x - cx) with whole turns added
/// so that neighbours differ by at most half a turn. rad, counted from +x towards +y. x, y     at least 1, mm
[[nodiscard]] SignalResult<Samples> unwrapped_angles(std::span<const double> x, std::span<const double> y,
                                                     double cx, double cy);

/// Where on a record that went round a given angle was passed.
struct AngleAlignment {
  Samples index;          ///< of each angle asked for, as a sample number with a fraction
  std::size_t begin = 0;  ///< the stretch of the record that was used: [begin, end)
  std::size_t end = 0;
  int turns = 0;  ///< whole turns added to the angles asked for
};

/// Aligns a ball-bar trace with a bus record: the longest stretch of `record` that turns one way without a
/// halt is taken, and every angle of `wanted` is looked up on it. Any signal of the bus at those moments is
/// then interpolate(sample numbers, signal, index).
///
/// record   rad, unwrapped, at least 2
/// wanted   rad, unwrapped; rising if the stretch rises and falling if it falls is not asked for
/// errors   no_overlap if the stretch does not cover all wanted angles, whatever whole turns are added
/// laws     AnglesAreFoundWhereTheyWere
[[nodiscard]] SignalResult<AngleAlignment> align_by_angle(std::span<const double> record,
                                                          std::span<const double> wanted);

}  // namespace abbe
