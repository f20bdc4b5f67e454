#include "abbe/signal/denoise.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>

#include "abbe/signal/wavelet_steps.h"

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
std::size_t shrink(std::span<double> details, double threshold, DenoiseOptions::Threshold kind) {
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

/// A decomposition in one piece of memory: details of all levels, and two approximations that take turns.
class Pyramid {
 public:
  Pyramid(std::span<const double> y, const Wavelet& wavelet, int levels) : wavelet_(wavelet) {
    std::size_t total = 0;
    for (std::size_t n = y.size(); static_cast<int>(lengths_.size()) < levels;) {
      lengths_.push_back(n);
      n = coefficient_count(n, wavelet);
      counts_.push_back(n);
      total += n;
    }
    // Not cleared: every place is written before it is read.
    const std::size_t first = counts_.front(), second = levels > 1 ? counts_[1] : 0;
    memory_.reset(new double[total + first + second]);
    low_ = {memory_.get() + total, memory_.get() + total + first};
    double* detail = memory_.get();
    for (std::size_t level = 0; level < counts_.size(); ++level) {
      details_.emplace_back(detail, counts_[level]);
      const std::span<const double> from =
          level == 0 ? y : std::span<const double>(low_[(level - 1) % 2], lengths_[level]);
      analyse(from, wavelet, low_[level % 2], detail);
      detail += counts_[level];
    }
  }

  [[nodiscard]] std::vector<std::span<double>>& details() { return details_; }  ///< finest first
  [[nodiscard]] std::size_t coefficients() const {
    std::size_t count = counts_.back();
    for (const std::size_t n : counts_) count += n;
    return count;
  }

  /// The record of the details as they are now; destroys the approximations.
  [[nodiscard]] Samples record() {
    Samples x(lengths_.front());
    for (std::size_t level = counts_.size(); level-- > 0;) {
      const std::span<double> out =
          level == 0 ? std::span<double>(x) : std::span(low_[(level - 1) % 2], lengths_[level]);
      synthesise(low_[level % 2], details_[level].data(), wavelet_, out);
    }
    return x;
  }

 private:
  const Wavelet& wavelet_;
  std::vector<std::size_t> lengths_, counts_;  ///< of what each level was made from, and of its coefficients
  std::unique_ptr<double[]> memory_;
  std::array<double*, 2> low_{};  ///< of odd and of even levels; the finest first
  std::vector<std::span<double>> details_;
};

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
  if (options.levels < 1 || options.levels > kMostLevels) return SignalProblem::bad_option;
  if (!all_finite(y)) return SignalProblem::not_finite;
  Pyramid pyramid(y, wavelet, options.levels);
  const std::size_t count =
      options.count == DenoiseOptions::Count::samples ? y.size() : pyramid.coefficients();
  // T = sigma sqrt(2 ln N)
  const double universal = std::sqrt(2 * std::log(static_cast<double>(count)));
  Denoised result;
  double sigma = options.sigma == DenoiseOptions::Sigma::one ? 1 : sigma_of(pyramid.details().front());
  for (const std::span<double> details : pyramid.details()) {
    if (options.sigma == DenoiseOptions::Sigma::per_level && !result.sigma.empty()) sigma = sigma_of(details);
    result.sigma.push_back(sigma);
    result.threshold.push_back(sigma * universal);
    result.kept.push_back(shrink(details, result.threshold.back(), options.threshold));
  }
  result.samples = pyramid.record();
  return result;
}

}  // namespace abbe
