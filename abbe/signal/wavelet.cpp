#include "abbe/signal/wavelet.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>

#include "abbe/signal/wavelet_taps.h"

namespace abbe {
namespace {

using wavelet_taps::kMostMoments;

constexpr std::size_t kMostTaps = 2 * kMostMoments;
constexpr std::size_t kHalfMost = kMostTaps / 2;
constexpr std::size_t kLanes = 16;  ///< sums made side by side: two registers of AVX-512, eight of SSE2

/// Filters split into the taps that meet even and those that meet odd samples.
struct Phases {
  std::array<double, kHalfMost> low_even{}, low_odd{}, high_even{}, high_odd{};
};

/// x(i) of the record continued by its mirror images, for any i.
double mirrored(std::span<const double> x, std::ptrdiff_t i) {
  const auto n = static_cast<std::ptrdiff_t>(x.size());
  i %= 2 * n;
  if (i < 0) i += 2 * n;
  return x[static_cast<std::size_t>(i < n ? i : 2 * n - 1 - i)];
}

// c_k = sum_j f_j x(2k + 1 - j): taps of even j meet odd samples. With o(k) = x(2k + 1), e(k) = x(2k):
//   c_k = sum_m f_{2m} o(k - m) + f_{2m+1} e(k - m)
Phases analysis_phases(const Wavelet& wavelet) {
  const std::span<const double> g = wavelet.scaling;
  const std::size_t n = g.size();
  Phases phases;
  for (std::size_t m = 0; m < n / 2; ++m) {
    phases.low_odd[m] = g[n - 1 - 2 * m];
    phases.low_even[m] = g[n - 2 - 2 * m];
    phases.high_odd[m] = -g[2 * m];
    phases.high_even[m] = g[2 * m + 1];
  }
  return phases;
}

// x(2i + p) = sum_m g_{2m+p} a(i + n/2 - 1 - m) + the same of the high-pass
Phases synthesis_phases(const Wavelet& wavelet) {
  const std::span<const double> g = wavelet.scaling;
  const std::size_t n = g.size();
  Phases phases;
  for (std::size_t m = 0; m < n / 2; ++m) {
    phases.low_even[m] = g[2 * m];
    phases.low_odd[m] = g[2 * m + 1];
    phases.high_even[m] = g[n - 1 - 2 * m];
    phases.high_odd[m] = -g[n - 2 - 2 * m];
  }
  return phases;
}

/// Sums of two inputs with two pairs of filters, for kLanes neighbouring places:
///   first[l] = sum_m f1_m a[l - m] + f2_m b[l - m],   second[l] = sum_m f3_m a[l - m] + f4_m b[l - m]
struct Filters {
  const double *first_a, *first_b, *second_a, *second_b;
};
inline void filter_lanes(const double* a, const double* b, std::size_t taps, const Filters& f, double* first,
                         double* second) {
  std::array<double, kLanes> s{}, t{};
  for (std::size_t m = 0; m < taps; ++m) {
    const double *pa = a - m, *pb = b - m;
    for (std::size_t l = 0; l < kLanes; ++l) {
      s[l] += f.first_a[m] * pa[l] + f.first_b[m] * pb[l];
      t[l] += f.second_a[m] * pa[l] + f.second_b[m] * pb[l];
    }
  }
  std::copy(s.begin(), s.end(), first);
  std::copy(t.begin(), t.end(), second);
}

/// The same for `count` places; a and b may be read kLanes beyond them, first and second written.
void filter_places(const double* a, const double* b, std::size_t taps, const Filters& f, double* first,
                   double* second, std::size_t count) {
  for (std::size_t k = 0; k < count; k += kLanes) filter_lanes(a + k, b + k, taps, f, first + k, second + k);
}

std::size_t coefficient_count(std::size_t samples, const Wavelet& wavelet) {
  return (samples + wavelet.scaling.size() - 1) / 2;
}

/// Pieces short enough to stay in the first cache.
constexpr std::size_t kPiece = 1024;

WaveletStep analyse(std::span<const double> x, const Wavelet& wavelet) {
  const std::size_t half = wavelet.scaling.size() / 2, count = coefficient_count(x.size(), wavelet);
  const Phases phases = analysis_phases(wavelet);
  const Filters filters = {phases.low_even.data(), phases.low_odd.data(), phases.high_even.data(),
                           phases.high_odd.data()};
  WaveletStep step;
  step.low.resize(count);
  step.high.resize(count);
  std::array<double, kPiece + kHalfMost + kLanes> even{}, odd{};
  std::array<double, kPiece + kLanes> low{}, high{};
  for (std::size_t begin = 0; begin < count; begin += kPiece) {
    const std::size_t places = std::min(kPiece, count - begin);
    // Slot s of even and odd is the pair of samples 2 (begin + s - (half - 1)) and the next.
    const auto first = 2 * (static_cast<std::ptrdiff_t>(begin) - static_cast<std::ptrdiff_t>(half - 1));
    const std::size_t slots = places + half - 1;
    if (first >= 0 && static_cast<std::size_t>(first) + 2 * slots <= x.size()) {
      const double* p = x.data() + first;
      for (std::size_t s = 0; s < slots; ++s) {
        even[s] = p[2 * s];
        odd[s] = p[2 * s + 1];
      }
    } else {
      for (std::size_t s = 0; s < slots; ++s) {
        even[s] = mirrored(x, first + 2 * static_cast<std::ptrdiff_t>(s));
        odd[s] = mirrored(x, first + 2 * static_cast<std::ptrdiff_t>(s) + 1);
      }
    }
    filter_places(even.data() + half - 1, odd.data() + half - 1, half, filters, low.data(), high.data(),
                  places);
    std::copy_n(low.begin(), places, step.low.begin() + static_cast<std::ptrdiff_t>(begin));
    std::copy_n(high.begin(), places, step.high.begin() + static_cast<std::ptrdiff_t>(begin));
  }
  return step;
}

Samples synthesise(std::span<const double> low, std::span<const double> high, const Wavelet& wavelet,
                   std::size_t length) {
  const std::size_t half = wavelet.scaling.size() / 2, pairs = (length + 1) / 2;
  const Phases phases = synthesis_phases(wavelet);
  const Filters filters = {phases.low_even.data(), phases.high_even.data(), phases.low_odd.data(),
                           phases.high_odd.data()};
  Samples x(length);
  std::array<double, kPiece + kHalfMost + kLanes> a{}, d{};
  std::array<double, kPiece + kLanes> even{}, odd{};
  for (std::size_t begin = 0; begin < pairs; begin += kPiece) {
    const std::size_t places = std::min(kPiece, pairs - begin);
    std::copy_n(low.begin() + static_cast<std::ptrdiff_t>(begin), places + half - 1, a.begin());
    std::copy_n(high.begin() + static_cast<std::ptrdiff_t>(begin), places + half - 1, d.begin());
    filter_places(a.data() + half - 1, d.data() + half - 1, half, filters, even.data(), odd.data(), places);
    double* out = x.data() + 2 * begin;
    const std::size_t whole = std::min(places, length / 2 - begin);
    for (std::size_t i = 0; i < whole; ++i) {
      out[2 * i] = even[i];
      out[2 * i + 1] = odd[i];
    }
    if (whole < places) out[2 * whole] = even[whole];
  }
  return x;
}

}  // namespace

std::optional<Wavelet> find_wavelet(std::string_view name) {
  if (name == "haar") return Wavelet{"haar", wavelet_taps::kDaubechies[0]};
  static const std::vector<std::string> names = wavelet_names();
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) return std::nullopt;
  const bool daubechies = name.starts_with("db");
  std::size_t moments = 0;
  const std::string_view digits = name.substr(daubechies ? 2 : 3);
  std::from_chars(digits.data(), digits.data() + digits.size(), moments);
  return Wavelet{*at, (daubechies ? wavelet_taps::kDaubechies : wavelet_taps::kSymlets)[moments - 1]};
}

std::vector<std::string> wavelet_names() {
  std::vector<std::string> names;
  for (int p = 1; p <= kMostMoments; ++p) names.push_back("db" + std::to_string(p));
  for (int p = 2; p <= kMostMoments; ++p) names.push_back("sym" + std::to_string(p));
  return names;
}

SignalResult<WaveletStep> dwt(std::span<const double> x, const Wavelet& wavelet) {
  if (x.empty()) return SignalProblem::too_short;
  if (!all_finite(x)) return SignalProblem::not_finite;
  return analyse(x, wavelet);
}

SignalResult<Samples> inverse_dwt(std::span<const double> low, std::span<const double> high,
                                  const Wavelet& wavelet, std::size_t length) {
  if (length == 0) return SignalProblem::too_short;
  const std::size_t count = coefficient_count(length, wavelet);
  if (low.size() != count || high.size() != count) return SignalProblem::sizes_differ;
  if (!all_finite(low) || !all_finite(high)) return SignalProblem::not_finite;
  return synthesise(low, high, wavelet, length);
}

std::size_t Decomposition::coefficients() const {
  std::size_t count = approximation.size();
  for (const Samples& detail : details) count += detail.size();
  return count;
}

SignalResult<Decomposition> decompose(std::span<const double> x, const Wavelet& wavelet, int levels) {
  if (levels < 1 || levels > kMostLevels) return SignalProblem::bad_option;
  if (x.empty()) return SignalProblem::too_short;
  if (!all_finite(x)) return SignalProblem::not_finite;
  Decomposition parts;
  for (int level = 0; level < levels; ++level) {
    const std::span<const double> from = level == 0 ? x : std::span<const double>(parts.approximation);
    parts.lengths.push_back(from.size());
    WaveletStep step = analyse(from, wavelet);
    parts.details.push_back(std::move(step.high));
    parts.approximation = std::move(step.low);
  }
  return parts;
}

SignalResult<Samples> reconstruct(const Decomposition& parts, const Wavelet& wavelet) {
  if (parts.details.empty() || parts.lengths.size() != parts.details.size())
    return SignalProblem::sizes_differ;
  Samples x = parts.approximation;
  for (std::size_t level = parts.details.size(); level-- > 0;) {
    SignalResult<Samples> finer = inverse_dwt(x, parts.details[level], wavelet, parts.lengths[level]);
    if (std::holds_alternative<SignalProblem>(finer)) return finer;
    x = std::move(std::get<Samples>(finer));
  }
  return x;
}

int useful_levels(std::size_t samples, const Wavelet& wavelet) {
  int levels = 0;
  for (std::size_t reach = 2 * (wavelet.scaling.size() - 1); reach <= samples; reach *= 2) ++levels;
  return levels;
}

}  // namespace abbe
