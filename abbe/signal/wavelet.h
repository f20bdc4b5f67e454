#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/signal/result.h"

namespace abbe {

/// An orthogonal wavelet as its reconstruction low-pass filter g (the scaling filter), 2 p taps for p
/// vanishing moments, sum g = sqrt 2. The other three filters follow from it:
///
///   decompose low   h_j = g_{n-1-j}            decompose high  (-1)^{j+1} g_j
///   reconstruct low g_j                        reconstruct high (-1)^j g_{n-1-j}
struct Wavelet {
  std::string_view name;
  std::span<const double> scaling;  ///< of static storage
};

/// db1 .. db20 (Daubechies; db1 is also "haar") and sym2 .. sym20 (her least asymmetric ones); nullopt for
/// any other name. laws     sum g_j g_{j+2k} = [k = 0], and p vanishing moments (FiltersAreOrthonormal)
/// source   Daubechies, Ten Lectures on Wavelets (1992), as PyWavelets 1.1.1 tabulates them
[[nodiscard]] std::optional<Wavelet> find_wavelet(std::string_view name);
[[nodiscard]] std::vector<std::string> wavelet_names();

/// One step of analysis: c_k = sum_j f_j x(2k + 1 - j), k = 0 .. floor((N + n - 1) / 2) - 1, where the record
/// is continued by its mirror image, edges repeated (half-point symmetric): x(-1-i) = x(i), x(N+i) =
/// x(N-1-i).
struct WaveletStep {
  Samples low, high;  ///< approximation and detail
};
/// x        at least 1 sample
/// cost     2 n products per pair of samples
[[nodiscard]] SignalResult<WaveletStep> dwt(std::span<const double> x, const Wavelet& wavelet);

/// The `length` samples from which dwt made `low` and `high` (both floor((length + n - 1) / 2) long).
/// laws     inverse_dwt(dwt(x)) = x (StepsInvert)
[[nodiscard]] SignalResult<Samples> inverse_dwt(std::span<const double> low, std::span<const double> high,
                                                const Wavelet& wavelet, std::size_t length);

/// Repeated steps on the approximation.
struct Decomposition {
  Samples approximation;                           ///< of the coarsest level
  std::vector<Samples> details;                    ///< finest level first
  std::vector<std::size_t> lengths;                ///< of what each level was made from; the record first
  [[nodiscard]] std::size_t coefficients() const;  ///< how many there are in all
};

inline constexpr int kMostLevels = 30;

/// levels   1 to kMostLevels. More than useful_levels are allowed, they only stir the margins.
[[nodiscard]] SignalResult<Decomposition> decompose(std::span<const double> x, const Wavelet& wavelet,
                                                    int levels);
[[nodiscard]] SignalResult<Samples> reconstruct(const Decomposition& parts, const Wavelet& wavelet);

/// floor(log2(N / (n - 1))): the level at which one tap still lies inside the record; at least 0.
[[nodiscard]] int useful_levels(std::size_t samples, const Wavelet& wavelet);

}  // namespace abbe
