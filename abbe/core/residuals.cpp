#include "abbe/core/residuals.h"

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr double kSuspicious = 3.5;  // |rho_1| sqrt n of white noise is above it once in two thousand records
constexpr double kLongMemory = 1.5;
constexpr std::size_t kMostLags = 4000;

double number(double x) { return std::isfinite(x) ? x : 0.0; }

double products(const std::vector<std::span<const double>>& records, std::size_t lag) {
  double sum = 0;
  for (const std::span<const double> r : records)
    for (std::size_t i = 0; i + lag < r.size(); ++i) sum += number(r[i]) * number(r[i + lag]);
  return sum;
}

}  // namespace

ResidualSummary summary_of_residuals(const std::vector<std::span<const double>>& records) {
  ResidualSummary out;
  std::size_t longest = 0;
  for (const std::span<const double> r : records) {
    out.count += r.size();
    longest = std::max(longest, r.size());
    for (const double x : r) out.largest = std::max(out.largest, std::abs(number(x)));
  }
  const double square = products(records, 0);
  if (out.count == 0 || !(square > 0) || !std::isfinite(square)) return out;
  const auto n = static_cast<double>(out.count);
  out.rms = std::sqrt(square / n);
  const std::size_t last = std::min(longest / 4, kMostLags);
  for (std::size_t k = 1; k <= last; ++k) {
    const double rho = products(records, k) / square;
    if (k == 1) out.lag_one = rho;
    if (rho < 2 / std::sqrt(n)) break;
    out.tau += 2 * rho;
  }
  out.white = std::abs(out.lag_one) <= kSuspicious / std::sqrt(n) && out.tau <= kLongMemory;
  return out;
}

}  // namespace abbe
