#include "abbe/evaluate/monte_carlo.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace abbe {

double RandomStream::uniform() {
  // 52 bits and a half: never 0, never 1.
  return (static_cast<double>(bits_() >> 12) + 0.5) * 0x1p-52;
}

double RandomStream::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  // Box and Muller: two uniform numbers give two normal ones.
  const double radius = std::sqrt(-2 * std::log(uniform())), angle = 2 * std::numbers::pi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

double RandomStream::gamma(double shape) {
  // Marsaglia and Tsang 2000; a shape below 1 by the power of a uniform number.
  if (shape < 1) return gamma(shape + 1) * std::pow(uniform(), 1 / shape);
  const double d = shape - 1.0 / 3, c = 1 / std::sqrt(9 * d);
  for (;;) {
    const double x = normal(), v = std::pow(1 + c * x, 3);
    if (v > 0 && std::log(uniform()) < x * x / 2 + d - d * v + d * std::log(v)) return d * v;
  }
}

double Distribution::draw(RandomStream& random) const {
  switch (kind) {
    case Kind::normal:
      return centre + width * random.normal();
    case Kind::student: {
      // t = z / sqrt(chi^2 / nu), chi^2 = 2 gamma(nu / 2)
      const double z = random.normal();
      return centre + width * z / std::sqrt(2 * random.gamma(extra / 2) / extra);
    }
    case Kind::rectangular:
      return centre + width * (2 * random.uniform() - 1);
    case Kind::arcsine:
      return centre + width * std::sin(2 * std::numbers::pi * random.uniform());
    case Kind::curvilinear_trapezoid: {
      const double limit = width + extra * (2 * random.uniform() - 1);
      return centre + limit * (2 * random.uniform() - 1);
    }
  }
  return centre;
}

MonteCarloResult summarise(std::vector<double> values, double probability) {
  values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); }),
               values.end());
  MonteCarloResult out;
  const std::size_t n = values.size();
  if (n < 2) return out;
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(n);
  for (const double value : values) out.mean += value / count;
  for (const double value : values) out.u += (value - out.mean) * (value - out.mean) / (count - 1);
  out.u = std::sqrt(out.u);
  // q values lie between the ends of an interval; of all such intervals one is the shortest.
  const std::size_t q =
      std::clamp<std::size_t>(static_cast<std::size_t>(probability * count + 0.5), 1, n - 1);
  const std::size_t middle = (n - q) / 2;
  out.symmetric = {values[middle], values[middle + q]};
  std::size_t best = 0;
  for (std::size_t i = 0; i + q < n; ++i)
    if (values[i + q] - values[i] < values[best + q] - values[best]) best = i;
  out.shortest = {values[best], values[best + q]};
  return out;
}

std::vector<MonteCarloResult> propagate(const std::vector<Distribution>& inputs, const MonteCarloModel& model,
                                        std::size_t trials, double probability, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<double> drawn(inputs.size());
  std::vector<std::vector<double>> values;
  for (std::size_t trial = 0; trial < trials; ++trial) {
    std::transform(inputs.begin(), inputs.end(), drawn.begin(),
                   [&](const Distribution& input) { return input.draw(random); });
    const std::vector<double> results = model(drawn);
    if (values.empty()) values.resize(results.size());
    for (std::size_t i = 0; i < results.size(); ++i) values[i].push_back(results[i]);
  }
  std::vector<MonteCarloResult> out;
  for (std::vector<double>& drawn_values : values)
    out.push_back(summarise(std::move(drawn_values), probability));
  return out;
}

}  // namespace abbe
