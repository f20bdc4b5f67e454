#include "abbe/signal/lag.h"

#include <cassert>
#include <cmath>

namespace abbe {

std::vector<double> first_order_lag(const std::vector<double>& times, const std::vector<double>& values,
                                    double tau) {
  assert(times.size() == values.size());
  std::vector<double> out = values;
  if (!(tau > 0)) return out;
  for (std::size_t k = 1; k < values.size(); ++k) {
    const double h = times[k] - times[k - 1];
    // m tau; steps far below the time constant lose no digits by expm1.
    const double rise = (values[k] - values[k - 1]) * tau / h;
    out[k] = out[k - 1] - (out[k - 1] - values[k - 1] + rise) * -std::expm1(-h / tau) +
             (values[k] - values[k - 1]);
  }
  return out;
}

}  // namespace abbe
