#include "abbe/signal/align.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <optional>
#include <unsupported/Eigen/FFT>

namespace abbe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kNone = -2;  // less than any correlation coefficient

Samples without_mean(std::span<const double> y) {
  const double mean = std::accumulate(y.begin(), y.end(), 0.0) / static_cast<double>(y.size());
  Samples out(y.size());
  std::transform(y.begin(), y.end(), out.begin(), [mean](double v) { return v - mean; });
  return out;
}

/// Scaled to at most 1, so that products of four are finite.
Samples normalised(std::span<const double> y) {
  Samples out = without_mean(y);
  double largest = 0;
  for (const double v : out) largest = std::max(largest, std::abs(v));
  if (largest > 0) {
    for (double& v : out) v /= largest;
  }
  return out;
}

/// sum_{i < k} y_i and sum_{i < k} y_i^2 for every k: sums over any stretch in two subtractions.
struct RunningSums {
  Samples sum, square;
  explicit RunningSums(const Samples& y) : sum(y.size() + 1), square(y.size() + 1) {
    for (std::size_t i = 0; i < y.size(); ++i) {
      sum[i + 1] = sum[i] + y[i];
      square[i + 1] = square[i] + y[i] * y[i];
    }
  }
};

/// sum_i a_i b_{i+l} for every l, at place l modulo the returned length: by the product of spectra.
Samples correlate(const Samples& a, const Samples& b) {
  std::size_t length = 1;
  while (length < a.size() + b.size()) length *= 2;
  Samples x(length), y(length), product(length);
  std::copy(a.begin(), a.end(), x.begin());
  std::copy(b.begin(), b.end(), y.begin());
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> spectrum_a, spectrum_b;
  fft.fwd(spectrum_a, x);
  fft.fwd(spectrum_b, y);
  for (std::size_t i = 0; i < spectrum_a.size(); ++i)
    spectrum_a[i] = std::conj(spectrum_a[i]) * spectrum_b[i];
  fft.inv(product, spectrum_a);
  return product;
}

/// r(l) of the overlap, from sums; kNone where one of the two does not vary there.
class Coefficients {
 public:
  Coefficients(const Samples& a, const Samples& b)
      : products_(correlate(a, b)), a_(a), b_(b), n_(a.size()), m_(b.size()) {}

  [[nodiscard]] std::size_t overlap(std::ptrdiff_t lag) const {
    const auto [from, to] = stretch(lag);
    return to > from ? static_cast<std::size_t>(to - from) : 0;
  }
  [[nodiscard]] double at(std::ptrdiff_t lag) const {
    const auto [from, to] = stretch(lag);
    const auto count = static_cast<double>(to - from);
    const auto part = [](const Samples& sums, std::ptrdiff_t begin, std::ptrdiff_t end) {
      return sums[static_cast<std::size_t>(end)] - sums[static_cast<std::size_t>(begin)];
    };
    const double sum_a = part(a_.sum, from, to), sum_b = part(b_.sum, from + lag, to + lag);
    // n cov = sum a b - sum a sum b / n, and so the variances
    const double var_a = part(a_.square, from, to) - sum_a * sum_a / count;
    const double var_b = part(b_.square, from + lag, to + lag) - sum_b * sum_b / count;
    if (var_a <= kFlat * count || var_b <= kFlat * count) return kNone;
    const auto length = static_cast<std::ptrdiff_t>(products_.size());
    const double product = products_[static_cast<std::size_t>((lag + length) % length)];
    return (product - sum_a * sum_b / count) / std::sqrt(var_a * var_b);
  }

 private:
  static constexpr double kFlat = 1e-12;  // of records scaled to 1: below, only rounding varies
  /// The i of a for which i + lag is a sample of b.
  [[nodiscard]] std::pair<std::ptrdiff_t, std::ptrdiff_t> stretch(std::ptrdiff_t lag) const {
    return {std::max<std::ptrdiff_t>(0, -lag),
            std::min(static_cast<std::ptrdiff_t>(n_), static_cast<std::ptrdiff_t>(m_) - lag)};
  }
  Samples products_;
  RunningSums a_, b_;
  std::size_t n_, m_;
};

constexpr double kEquallyGood = 1e-3, kBetweenPeaks = 0.1;

/// The peak closest to `zero` among those as high as the highest, for records that repeat themselves. Two
/// maxima are of one peak, of which only the higher counts, unless r falls well below the highest between
/// them: ripples that noise puts on a broad peak are no repetitions.
std::size_t smallest_of_best(const Samples& r, std::size_t zero) {
  const double top = *std::max_element(r.begin(), r.end());
  const auto away = [zero](std::size_t i) { return i > zero ? i - zero : zero - i; };
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (r[i] < top - kBetweenPeaks) continue;
    std::size_t peak = i;
    for (; i < r.size() && r[i] >= top - kBetweenPeaks; ++i) {
      if (r[i] > r[peak]) peak = i;
    }
    if (r[peak] >= top - kEquallyGood && (!best || away(peak) < away(*best))) best = peak;
  }
  return best.value_or(zero);
}

/// The largest range [begin, end) in which the record rises strictly.
std::pair<std::size_t, std::size_t> longest_rise(const Samples& angle) {
  std::size_t begin = 0, best_begin = 0, best_end = 1;
  for (std::size_t i = 1; i <= angle.size(); ++i) {
    if (i < angle.size() && angle[i] > angle[i - 1]) continue;
    if (angle[i - 1] - angle[begin] > angle[best_end - 1] - angle[best_begin]) {
      best_begin = begin;
      best_end = i;
    }
    begin = i;
  }
  return {best_begin, best_end};
}

/// The angle of a stretch for wanted angles, turned so that the stretch rises.
struct Turning {
  double sign = 1;
  std::size_t begin = 0, end = 0;
};
Turning longest_turn(std::span<const double> record) {
  Samples forward(record.begin(), record.end()), backward(record.size());
  std::transform(record.begin(), record.end(), backward.begin(), [](double a) { return -a; });
  const auto [f_begin, f_end] = longest_rise(forward);
  const auto [b_begin, b_end] = longest_rise(backward);
  if (forward[f_end - 1] - forward[f_begin] >= backward[b_end - 1] - backward[b_begin])
    return {1, f_begin, f_end};
  return {-1, b_begin, b_end};
}

double index_at(std::span<const double> record, const Turning& turning, double angle) {
  const auto first = record.begin() + static_cast<std::ptrdiff_t>(turning.begin);
  const auto last = record.begin() + static_cast<std::ptrdiff_t>(turning.end);
  auto above = std::upper_bound(first, last, turning.sign * angle,
                                [&](double value, double element) { return value < turning.sign * element; });
  above = std::clamp(above, first + 1, last - 1);
  const double part = (angle - *(above - 1)) / (*above - *(above - 1));
  return static_cast<double>(above - 1 - record.begin()) + part;
}

}  // namespace

SignalResult<Delay> find_delay(std::span<const double> a, std::span<const double> b,
                               const DelayOptions& options) {
  if (!(options.least_overlap > 0 && options.least_overlap <= 1)) return SignalProblem::bad_option;
  if (a.size() < 4 || b.size() < 4) return SignalProblem::too_short;
  if (!all_finite(a) || !all_finite(b)) return SignalProblem::not_finite;
  const Coefficients r(normalised(a), normalised(b));
  const double shorter = static_cast<double>(std::min(a.size(), b.size()));
  const auto least = static_cast<std::size_t>(std::max(3.0, std::ceil(options.least_overlap * shorter)));
  const auto bound = [&](std::size_t size) {
    return static_cast<std::ptrdiff_t>(options.most == 0 ? size : std::min(options.most, size));
  };
  const auto allowed = [&](std::ptrdiff_t lag) { return r.overlap(lag) >= least; };
  const std::ptrdiff_t from = -bound(a.size()), to = bound(b.size());
  Samples by_lag;
  for (std::ptrdiff_t lag = from; lag <= to; ++lag) by_lag.push_back(allowed(lag) ? r.at(lag) : kNone);
  const std::size_t chosen = smallest_of_best(by_lag, static_cast<std::size_t>(-from));
  const std::ptrdiff_t best = from + static_cast<std::ptrdiff_t>(chosen);
  const double coefficient = by_lag[chosen];
  if (coefficient < -1.5) return SignalProblem::constant;
  Delay delay = {static_cast<double>(best), std::clamp(coefficient, -1.0, 1.0)};
  if (allowed(best - 1) && allowed(best + 1)) {
    // the top of the parabola through three neighbours: (r- - r+) / (2 (r- - 2 r0 + r+))
    const double before = r.at(best - 1), after = r.at(best + 1), bend = before - 2 * coefficient + after;
    if (before > -1.5 && after > -1.5 && bend < 0) delay.samples += (before - after) / (2 * bend);
  }
  return delay;
}

SignalResult<Samples> unwrapped_angles(std::span<const double> x, std::span<const double> y, double cx,
                                       double cy) {
  if (x.size() != y.size()) return SignalProblem::sizes_differ;
  if (x.empty()) return SignalProblem::too_short;
  if (!all_finite(x) || !all_finite(y) || !std::isfinite(cx) || !std::isfinite(cy))
    return SignalProblem::not_finite;
  Samples angle(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    angle[i] = std::atan2(y[i] - cy, x[i] - cx);
    if (i > 0) angle[i] += kTurn * std::round((angle[i - 1] - angle[i]) / kTurn);
  }
  return angle;
}

SignalResult<AngleAlignment> align_by_angle(std::span<const double> record, std::span<const double> wanted) {
  if (record.size() < 2 || wanted.empty()) return SignalProblem::too_short;
  if (!all_finite(record) || !all_finite(wanted)) return SignalProblem::not_finite;
  const Turning turning = longest_turn(record);
  if (turning.end - turning.begin < 2) return SignalProblem::constant;
  const auto [low, high] = std::minmax(record[turning.begin], record[turning.end - 1]);
  const auto [least, most] = std::minmax_element(wanted.begin(), wanted.end());
  // Slack for angles that are those of the ends but for rounding.
  const double slack = 1e-9 * (1 + std::abs(low) + std::abs(high));
  const double turns = std::ceil((low - slack - *least) / kTurn);
  if (*most + turns * kTurn > high + slack) return SignalProblem::no_overlap;

  AngleAlignment alignment;
  alignment.begin = turning.begin;
  alignment.end = turning.end;
  alignment.turns = static_cast<int>(turns);
  alignment.index.reserve(wanted.size());
  for (const double angle : wanted) {
    alignment.index.push_back(index_at(record, turning, std::clamp(angle + turns * kTurn, low, high)));
  }
  return alignment;
}

}  // namespace abbe
