#include "abbe/signal/denoise.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace abbe {
namespace {

constexpr double kNormalQuartile = 0.6745;  // of |x|, the median of a normal distribution in units of sigma

/// The k-th smallest of |v|, k from 0. Magnitudes of doubles are ordered like their bits, so a count of the
/// leading ones says which few values have to be sorted at all.
class MagnitudeRanks {
 public:
  explicit MagnitudeRanks(std::span<const double> v) : v_(v), counts_(std::size_t{1} << kLeading) {
    for (const double value : v) ++counts_[bucket_of(value)];
  }
  [[nodiscard]] double at(std::size_t rank) {
    std::size_t bucket = 0, below = 0;
    while (below + counts_[bucket] <= rank) below += counts_[bucket++];
    if (bucket != bucket_ || members_.empty()) {
      bucket_ = bucket;
      members_.clear();
      members_.reserve(counts_[bucket]);
      for (const double value : v_) {
        if (bucket_of(value) == bucket) members_.push_back(std::abs(value));
      }
    }
    const auto at = members_.begin() + static_cast<std::ptrdiff_t>(rank - below);
    std::nth_element(members_.begin(), at, members_.end());
    return *at;
  }

 private:
  static constexpr int kLeading = 16;  ///< 11 bits of exponent, 5 of the fraction: a bucket is 3 % wide
  [[nodiscard]] static std::size_t bucket_of(double value) {
    return static_cast<std::size_t>((std::bit_cast<std::uint64_t>(value) << 1) >> (64 - kLeading));
  }
  std::span<const double> v_;
  std::vector<std::uint32_t> counts_;
  std::size_t bucket_ = 0;
  std::vector<double> members_;
};

/// How many are kept.
std::size_t shrink(Samples& details, double threshold, DenoiseOptions::Threshold kind) {
  std::size_t kept = 0;
  const bool hard = kind == DenoiseOptions::Threshold::hard;
  for (double& c : details) {
    const double magnitude = std::abs(c);
    const bool keep = magnitude > threshold;
    kept += keep ? 1 : 0;
    // soft: sign(c) max(|c| - T, 0)
    c = keep ? (hard ? c : std::copysign(magnitude - threshold, c)) : 0.0;
  }
  return kept;
}

double sigma_of(std::span<const double> details) { return median_magnitude(details) / kNormalQuartile; }

}  // namespace

double median_magnitude(std::span<const double> v) {
  if (v.empty()) return 0;
  MagnitudeRanks ranks(v);
  const double upper = ranks.at(v.size() / 2);
  return v.size() % 2 == 1 ? upper : (ranks.at(v.size() / 2 - 1) + upper) / 2;
}

SignalResult<Denoised> denoise(std::span<const double> y, const Wavelet& wavelet,
                               const DenoiseOptions& options) {
  if (y.size() < 2) return SignalProblem::too_short;
  SignalResult<Decomposition> decomposed = decompose(y, wavelet, options.levels);
  if (const auto* problem = std::get_if<SignalProblem>(&decomposed)) return *problem;
  auto& parts = std::get<Decomposition>(decomposed);

  const std::size_t count = options.count == DenoiseOptions::Count::samples ? y.size() : parts.coefficients();
  // T = sigma sqrt(2 ln N)
  const double universal = std::sqrt(2 * std::log(static_cast<double>(count)));
  Denoised result;
  double sigma = options.sigma == DenoiseOptions::Sigma::one ? 1 : sigma_of(parts.details.front());
  for (Samples& details : parts.details) {
    if (options.sigma == DenoiseOptions::Sigma::per_level && !result.sigma.empty()) sigma = sigma_of(details);
    result.sigma.push_back(sigma);
    result.threshold.push_back(sigma * universal);
    result.kept.push_back(shrink(details, result.threshold.back(), options.threshold));
  }
  SignalResult<Samples> samples = reconstruct(parts, wavelet);
  if (const auto* problem = std::get_if<SignalProblem>(&samples)) return *problem;
  result.samples = std::move(std::get<Samples>(samples));
  return result;
}

}  // namespace abbe
