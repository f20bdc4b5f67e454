#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "abbe/signal/result.h"
#include "abbe/signal/wavelet.h"

namespace abbe {

/// Wavelet shrinkage with the universal threshold: details below T are noise.
///
///   T = sigma sqrt(2 ln N)
///   hard: c if |c| > T, else 0        soft: sign(c) max(|c| - T, 0)
///
/// The coarsest approximation stays as it is.
struct DenoiseOptions {
  /// The noise: `first` is median |d_1| / 0.6745 of the finest details, used at every level; `per_level` the
  /// same of each level; `one` takes it as 1, for signals divided by their noise.
  enum class Sigma { first, per_level, one };
  /// What N counts: the samples, or all coefficients (there are a few more).
  enum class Count { samples, coefficients };
  enum class Threshold { hard, soft };

  int levels = 5;  ///< 1 to kMostLevels
  Threshold threshold = Threshold::hard;
  Sigma sigma = Sigma::first;
  Count count = Count::samples;
};

struct Denoised {
  Samples samples;
  std::vector<double> sigma;      ///< used at each level, finest first, unit of the record
  std::vector<double> threshold;  ///< the same
  std::vector<std::size_t> kept;  ///< details of each level that are not zero afterwards, finest first
};

/// y        at least 2 samples
/// laws     without noise above T nothing changes (NothingIsLostBelowZeroThreshold)
/// cost     about 6 n products per sample for a wavelet of n taps, and one pass for the median
/// source   Donoho, Johnstone, Biometrika 81 (1994) 425; 0.6745 is the third quartile of the normal
/// distribution
[[nodiscard]] SignalResult<Denoised> denoise(std::span<const double> y, const Wavelet& wavelet,
                                             const DenoiseOptions& options = {});

/// The median of |v|, of an even count the mean of the two in the middle; 0 of no values. `v` must be finite.
/// cost     two passes and a few comparisons: what is looked for is found by its leading bits first
[[nodiscard]] double median_magnitude(std::span<const double> v);

}  // namespace abbe
