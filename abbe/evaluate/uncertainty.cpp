#include "abbe/evaluate/uncertainty.h"

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

/// Continued fraction of the incomplete beta function, by Lentz's method (Abramowitz and Stegun 26.5.8).
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300, kDone = 1e-16;
  constexpr int kMost = 10'000;
  const auto away_from_zero = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1, d = 1 / away_from_zero(1 - (a + b) * x / (a + 1)), fraction = d;
  for (int m = 1; m <= kMost; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    double step = 1;
    for (const double term : {even, odd}) {
      d = 1 / away_from_zero(1 + term * d);
      c = away_from_zero(1 + term / c);
      step = d * c;
      fraction *= step;
    }
    if (std::abs(step - 1) < kDone) break;
  }
  return fraction;
}

/// Regularised incomplete beta function I_x(a, b).
double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

/// P(|T| <= t). Beyond kNormal degrees of freedom the normal distribution is the same to 1e-9.
double student_probability(double t, double nu) {
  constexpr double kNormal = 1e8;
  if (nu > kNormal) return std::erf(t / std::sqrt(2.0));
  // P = 1 - I_x(nu / 2, 1 / 2) with x = nu / (nu + t^2)
  return 1 - incomplete_beta(nu / 2, 0.5, nu / (nu + t * t));
}

}  // namespace

double student_factor(double probability, double degrees_of_freedom) {
  const double nu = degrees_of_freedom >= 1 ? degrees_of_freedom : 1;
  const double p = std::clamp(probability, 0.0, 1 - 1e-12);
  double lo = 0, hi = 1;
  while (student_probability(hi, nu) < p && hi < 1e15) hi *= 2;
  for (int i = 0; i < 200 && hi - lo > 1e-15 * hi; ++i) {
    const double t = (lo + hi) / 2;
    (student_probability(t, nu) < p ? lo : hi) = t;
  }
  return (lo + hi) / 2;
}

double CombinedUncertainty::expanded_95() const { return student_factor(0.95, degrees_of_freedom) * u; }

std::optional<CombinedUncertainty> combine(const std::vector<UncertaintyInput>& inputs,
                                           const Eigen::MatrixXd& correlation) {
  const auto n = static_cast<Eigen::Index>(inputs.size());
  Eigen::VectorXd contribution(n);
  double fourth = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const UncertaintyInput& input = inputs[static_cast<std::size_t>(i)];
    if (!std::isfinite(input.u) || !std::isfinite(input.sensitivity) || input.u < 0 ||
        !(input.degrees_of_freedom > 0))
      return std::nullopt;
    contribution[i] = input.sensitivity * input.u;
    fourth += std::pow(contribution[i], 4) / input.degrees_of_freedom;
  }
  double variance = contribution.squaredNorm();
  if (correlation.size() != 0) {
    if (correlation.rows() != n || correlation.cols() != n || !(correlation.array().abs() <= 1).all())
      return std::nullopt;
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < i; ++j)
        variance += 2 * contribution[i] * contribution[j] * correlation(i, j);
  }
  if (!std::isfinite(variance) || variance < 0) return std::nullopt;
  CombinedUncertainty out;
  out.u = std::sqrt(variance);
  if (fourth > 0) out.degrees_of_freedom = variance * variance / fourth;
  return out;
}

double uncertainty_of_range(double width) { return std::abs(width) / std::sqrt(12.0); }

}  // namespace abbe
