#pragma once

#include <optional>
#include <span>

#include "abbe/signal/result.h"

namespace abbe {

/// y(t) = A sin(omega t + phi) + c with A > 0 and phi in (-pi, pi].
struct Sine {
  double amplitude = 0;  ///< A, unit of y
  double omega = 0;      ///< rad/s
  double phase = 0;      ///< rad
  double offset = 0;     ///< c, unit of y

  [[nodiscard]] double at(double t) const;
};

struct SineOptions {
  bool with_offset = true;            ///< false: c = 0
  std::optional<double> omega_start;  ///< rad/s; not given: found from the periodogram
  double omega_max = 0;               ///< rad/s, of the search; 0: half the mean sampling rate
};

struct SineFit {
  Sine sine;
  Sine
      uncertainty;  ///< standard uncertainty of each number, from the residuals; 0 if there are none to spare
  double sse = 0;   ///< sum of the squared residuals
  int iterations = 0;
};

/// Least squares by a search over omega (at a given omega the rest is linear), then Gauss-Newton steps with
/// halving. Records of less than about one period leave A, omega, phi and c nearly undetermined: see
/// the uncertainties.
///
/// t        s, strictly increasing, as many as y, at least 5
/// errors   constant if y does not vary; not_converged
/// laws     a sine is found to rounding (SinesAreFound)
/// cost     O(n log n) if t is equally spaced, else O(n^2)
/// source   IEEE Std 1057, sine-wave fit with four parameters
[[nodiscard]] SignalResult<SineFit> fit_sine(std::span<const double> t, std::span<const double> y,
                                             const SineOptions& options = {});

}  // namespace abbe
