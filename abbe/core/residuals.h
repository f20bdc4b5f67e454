#pragma once

#include <span>
#include <vector>

namespace abbe {

/// What the residuals of a fit say about the model: independent noise, or something left to explain.
///
///     autocorrelation  rho_k = sum r_i r_{i+k} / sum r_i^2, over neighbours of one record
///     tau              1 + 2 sum rho_k up to the first k with rho_k < 2 / sqrt n (at most n / 4)
///     white            |rho_1| <= kSuspicious / sqrt n and tau <= kLongMemory
///
/// n residuals whose neighbours resemble each other carry what n / tau independent ones carry: a variance
/// from the fit has to be multiplied by tau.
struct ResidualSummary {
  std::size_t count = 0;
  double rms = 0;
  double largest = 0;  ///< absolute value
  double lag_one = 0;  ///< rho_1
  double tau = 1;      ///< never below 1
  bool white = true;
};

/// records  each in the order of its samples; neighbours are sought within a record only
/// errors   empty input gives zeros; numbers that are not finite count as 0
/// laws     WhiteNoiseIsWhite, SineIsNotWhite, TauOfAnAutoregressiveProcess
/// cost     O(n k) up to the last lag looked at
/// source   Sokal: Monte Carlo Methods in Statistical Mechanics (1997), section 3
[[nodiscard]] ResidualSummary summary_of_residuals(const std::vector<std::span<const double>>& records);

}  // namespace abbe
