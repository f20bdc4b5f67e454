#pragma once

#include <string_view>
#include <vector>

#include "abbe/evaluate/run_table.h"

namespace abbe {

/// Mean, spread and reversal at one target, from both directions of approach.
struct PositioningTarget {
  double position = 0;
  double mean_forward = 0, mean_backward = 0, mean = 0;
  double s_forward = 0, s_backward = 0;  ///< sample standard deviations, n - 1
  double reversal = 0;                   ///< B_i = mean_forward - mean_backward, signed
  double repeatability = 0;              ///< R_i, both directions
};

/// A figure of one direction and of both. NaN never: what cannot be evaluated says so by `evaluated`.
struct DirectionalFigure {
  double forward = 0, backward = 0, both = 0;
};

/// The figures of ISO 230-2:2014 (numerically those of 2006), coverage factor k = 2. With
/// x_i = mean over the runs at target i, s_i its sample standard deviation:
///
///   E forward       max x_i - min x_i of that direction; both: over both directions
///   R forward       max 4 s_i of that direction; both: max R_i,
///                   R_i = max(2 s_f + 2 s_b + |B_i|, 4 s_f, 4 s_b)
///   A forward       max(x_i + 2 s_i) - min(x_i - 2 s_i) of that direction; both: over both directions
///   M               max - min of (x_f + x_b) / 2
///   B               max |B_i|; mean_reversal = mean of the signed B_i
///
/// units    mm or rad, like the deviations
struct PositioningFigures {
  static constexpr std::string_view kEdition = "ISO 230-2:2014";
  static constexpr int kCoverage = 2;

  std::vector<PositioningTarget> targets;
  DirectionalFigure E, R, A;
  double M = 0, B = 0, mean_reversal = 0;
  int runs_forward = 0, runs_backward = 0;

  /// R and A need a standard deviation: two runs of every direction measured.
  [[nodiscard]] bool has_spread() const;
  [[nodiscard]] bool bidirectional() const { return runs_forward > 0 && runs_backward > 0; }
};

/// Evaluates runs. A table of one direction has the figures of that direction, repeated in `both`; M is then
/// its E, B and mean_reversal are 0.
///
/// laws     WorkedExampleOne, WorkedExampleTwo, DirectionsSwapWithTheSignOfReversal, ConstantsDoNotCount
/// cost     O(targets * runs)
/// source   ISO 230-2:2014 as other implementations print it (docs/theory/measurement.md)
[[nodiscard]] PositioningFigures positioning_figures(const RunTable& table);

}  // namespace abbe
