#include "abbe/signal/resample.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace abbe {
namespace {

constexpr double kMostSamples = 1e8;

bool strictly_increasing(std::span<const double> x) {
  return std::adjacent_find(x.begin(), x.end(), [](double a, double b) { return !(a < b); }) == x.end();
}

/// The i with x_i <= at < x_{i+1}, at most n - 2. Looks near the last one first.
class Interval {
 public:
  explicit Interval(std::span<const double> x) : x_(x) {}
  [[nodiscard]] std::size_t of(double at) {
    const std::size_t last = x_.size() - 2;
    if (at >= x_[i_] && i_ < last && at >= x_[i_ + 1]) ++i_;
    const bool inside = at >= x_[i_] && (i_ == last || at < x_[i_ + 1]);
    if (!inside) {
      const auto above = std::upper_bound(x_.begin(), x_.end(), at) - x_.begin();
      i_ = std::min(last, static_cast<std::size_t>(std::max<std::ptrdiff_t>(above - 1, 0)));
    }
    return i_;
  }

 private:
  std::span<const double> x_;
  std::size_t i_ = 0;
};

/// The polynomial through the points [first, last] of the record, at `at`: Lagrange's form.
double lagrange(std::span<const double> x, std::span<const double> y, std::size_t first, std::size_t last,
                double at) {
  double sum = 0;
  for (std::size_t i = first; i <= last; ++i) {
    double weight = 1;
    for (std::size_t j = first; j <= last; ++j) {
      if (j != i) weight *= (at - x[j]) / (x[i] - x[j]);
    }
    sum += weight * y[i];
  }
  return sum;
}

}  // namespace

SignalResult<Samples> interpolate(std::span<const double> x, std::span<const double> y,
                                  std::span<const double> at, Interpolation kind) {
  if (x.size() != y.size()) return SignalProblem::sizes_differ;
  if (x.size() < 2) return SignalProblem::too_short;
  if (!all_finite(x) || !all_finite(y) || !all_finite(at)) return SignalProblem::not_finite;
  if (!strictly_increasing(x)) return SignalProblem::not_increasing;
  Interval interval(x);
  const std::size_t spare = x.size() - std::min<std::size_t>(x.size(), 4);
  Samples values;
  values.reserve(at.size());
  for (const double place : at) {
    if (place < x.front() || place > x.back()) return SignalProblem::no_overlap;
    const std::size_t i = interval.of(place);
    // At the ends the four nearest are the first or last four.
    const std::size_t first =
        kind == Interpolation::linear ? i : std::min(i - std::min<std::size_t>(i, 1), spare);
    const std::size_t last = std::min(x.size() - 1, first + (kind == Interpolation::linear ? 1 : 3));
    values.push_back(lagrange(x, y, first, last, place));
  }
  // Neighbours almost at one place can make the cubic through four points overshoot every bound.
  if (!all_finite(values)) return SignalProblem::not_increasing;
  return values;
}

SignalResult<UniformRecord> resample(std::span<const double> x, std::span<const double> y, double spacing,
                                     Interpolation kind) {
  if (!(spacing > 0) || !std::isfinite(spacing)) return SignalProblem::bad_option;
  if (x.size() < 2) return SignalProblem::too_short;
  if (!all_finite(x)) return SignalProblem::not_finite;
  // One ulp of slack: 0, 0.1, .. 1 shall reach 1.
  const double steps = std::floor((x.back() - x.front()) / spacing * (1 + 1e-12));
  if (!(steps >= 0)) return SignalProblem::not_increasing;
  if (steps >= kMostSamples) return SignalProblem::bad_option;
  Samples at(static_cast<std::size_t>(steps) + 1);
  for (std::size_t i = 0; i < at.size(); ++i) {
    at[i] = std::min(x.back(), x.front() + static_cast<double>(i) * spacing);
  }
  SignalResult<Samples> samples = interpolate(x, y, at, kind);
  if (const auto* problem = std::get_if<SignalProblem>(&samples)) return *problem;
  return UniformRecord{x.front(), spacing, std::move(std::get<Samples>(samples))};
}

}  // namespace abbe
