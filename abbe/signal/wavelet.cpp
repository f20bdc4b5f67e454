#include "abbe/signal/wavelet.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cstring>

#include "abbe/signal/wavelet_steps.h"
#include "abbe/signal/wavelet_taps.h"

// One machine code per instruction set, chosen when the program is loaded. Sanitizers start later than that.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define ABBE_FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define ABBE_FOR_EACH_PROCESSOR
#endif

namespace abbe {
namespace {

using wavelet_taps::kMostMoments;

constexpr std::size_t kMostTaps = 2 * kMostMoments;
constexpr std::size_t kHalfMost = kMostTaps / 2;
constexpr std::size_t kLanes = 8;  ///< sums made side by side: one register of AVX-512, four of SSE2
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));

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

/// Sums of two inputs with two pairs of filters:
///   first[k] = sum_m f1_m a[k - m] + f2_m b[k - m],   second[k] = sum_m f3_m a[k - m] + f4_m b[k - m]
struct Filters {
  const double *first_a, *first_b, *second_a, *second_b;
};

/// For `count` places, kLanes at a time; a and b may be read kLanes beyond them, first and second written.
/// Without fused products the sums are the same on every processor.
ABBE_FOR_EACH_PROCESSOR void filter_places(const double* a, const double* b, std::size_t taps,
                                           const Filters& f, double* first, double* second,
                                           std::size_t count) {
  for (std::size_t k = 0; k < count; k += kLanes) {
    Lanes s{}, t{};
    for (std::size_t m = 0; m < taps; ++m) {
      Lanes here_a, here_b;
      std::memcpy(&here_a, a + k - m, sizeof here_a);
      std::memcpy(&here_b, b + k - m, sizeof here_b);
      s += f.first_a[m] * here_a + f.first_b[m] * here_b;
      t += f.second_a[m] * here_a + f.second_b[m] * here_b;
    }
    std::memcpy(first + k, &s, sizeof s);
    std::memcpy(second + k, &t, sizeof t);
  }
}

/// Pieces short enough to stay in the first cache.
constexpr std::size_t kPiece = 1024;
using Phase = std::array<double, kPiece + kHalfMost + kLanes>;

/// Even and odd samples of the mirrored record: slot s is the pair at `first` + 2 s.
void split(std::span<const double> x, std::ptrdiff_t first, std::size_t slots, Phase& even, Phase& odd) {
  if (first >= 0 && static_cast<std::size_t>(first) + 2 * slots <= x.size()) {
    const double* p = x.data() + first;
    for (std::size_t s = 0; s < slots; ++s) {
      even[s] = p[2 * s];
      odd[s] = p[2 * s + 1];
    }
    return;
  }
  for (std::size_t s = 0; s < slots; ++s) {
    even[s] = mirrored(x, first + 2 * static_cast<std::ptrdiff_t>(s));
    odd[s] = mirrored(x, first + 2 * static_cast<std::ptrdiff_t>(s) + 1);
  }
}

}  // namespace

void analyse(std::span<const double> x, const Wavelet& wavelet, double* low, double* high) {
  const std::size_t half = wavelet.scaling.size() / 2, count = coefficient_count(x.size(), wavelet);
  const Phases phases = analysis_phases(wavelet);
  const Filters filters = {phases.low_even.data(), phases.low_odd.data(), phases.high_even.data(),
                           phases.high_odd.data()};
  Phase even{}, odd{}, last_low{}, last_high{};
  for (std::size_t begin = 0; begin < count; begin += kPiece) {
    const std::size_t places = std::min(kPiece, count - begin);
    const auto first = 2 * (static_cast<std::ptrdiff_t>(begin) - static_cast<std::ptrdiff_t>(half - 1));
    split(x, first, places + half - 1, even, odd);
    const double *a = even.data() + half - 1, *b = odd.data() + half - 1;
    if (places == kPiece) {
      filter_places(a, b, half, filters, low + begin, high + begin, places);
    } else {  // the last one writes up to kLanes more than there is room for
      filter_places(a, b, half, filters, last_low.data(), last_high.data(), places);
      std::copy_n(last_low.begin(), places, low + begin);
      std::copy_n(last_high.begin(), places, high + begin);
    }
  }
}

void synthesise(const double* low, const double* high, const Wavelet& wavelet, std::span<double> x) {
  const std::size_t half = wavelet.scaling.size() / 2, pairs = (x.size() + 1) / 2;
  const Phases phases = synthesis_phases(wavelet);
  const Filters filters = {phases.low_even.data(), phases.high_even.data(), phases.low_odd.data(),
                           phases.high_odd.data()};
  Phase last_low{}, last_high{}, even{}, odd{};
  for (std::size_t begin = 0; begin < pairs; begin += kPiece) {
    const std::size_t places = std::min(kPiece, pairs - begin);
    const double *a = low + begin, *d = high + begin;
    if (places < kPiece) {  // the last one reads up to kLanes more than there are
      std::copy_n(a, places + half - 1, last_low.begin());
      std::copy_n(d, places + half - 1, last_high.begin());
      a = last_low.data();
      d = last_high.data();
    }
    filter_places(a + half - 1, d + half - 1, half, filters, even.data(), odd.data(), places);
    double* out = x.data() + 2 * begin;
    const std::size_t whole = std::min(places, x.size() / 2 - begin);
    for (std::size_t i = 0; i < whole; ++i) {
      out[2 * i] = even[i];
      out[2 * i + 1] = odd[i];
    }
    if (whole < places) out[2 * whole] = even[whole];
  }
}

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
  WaveletStep step;
  step.low.resize(coefficient_count(x.size(), wavelet));
  step.high.resize(step.low.size());
  analyse(x, wavelet, step.low.data(), step.high.data());
  return step;
}

SignalResult<Samples> inverse_dwt(std::span<const double> low, std::span<const double> high,
                                  const Wavelet& wavelet, std::size_t length) {
  if (length == 0) return SignalProblem::too_short;
  const std::size_t count = coefficient_count(length, wavelet);
  if (low.size() != count || high.size() != count) return SignalProblem::sizes_differ;
  if (!all_finite(low) || !all_finite(high)) return SignalProblem::not_finite;
  Samples x(length);
  synthesise(low.data(), high.data(), wavelet, x);
  return x;
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
    Samples low(coefficient_count(from.size(), wavelet));
    parts.details.emplace_back(low.size());
    analyse(from, wavelet, low.data(), parts.details.back().data());
    parts.approximation = std::move(low);
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
