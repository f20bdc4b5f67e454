#include "abbe/signal/differentiate.h"

namespace abbe {

SignalResult<Samples> differentiate(std::span<const double> y, double dt) {
  if (!(dt > 0) || !std::isfinite(dt)) return SignalProblem::bad_option;
  if (y.size() < 3) return SignalProblem::too_short;
  if (!all_finite(y)) return SignalProblem::not_finite;
  const std::size_t n = y.size();
  const double step = 2 * dt;
  Samples v(n);
  v[0] = (-3 * y[0] + 4 * y[1] - y[2]) / step;
  for (std::size_t i = 1; i + 1 < n; ++i) v[i] = (y[i + 1] - y[i - 1]) / step;
  v[n - 1] = (3 * y[n - 1] - 4 * y[n - 2] + y[n - 3]) / step;
  if (!all_finite(v)) return SignalProblem::bad_option;  // dt so small that the quotient overflows
  return v;
}

}  // namespace abbe
