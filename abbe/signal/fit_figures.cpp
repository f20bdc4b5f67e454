#include "abbe/signal/fit_figures.h"

#include <cmath>
#include <numeric>

namespace abbe {

SignalResult<FitFigures> fit_figures(std::span<const double> y, std::span<const double> f,
                                     std::size_t parameters) {
  if (y.size() != f.size()) return SignalProblem::sizes_differ;
  if (y.empty()) return SignalProblem::too_short;
  if (!all_finite(y) || !all_finite(f)) return SignalProblem::not_finite;
  FitFigures figures;
  figures.samples = y.size();
  figures.parameters = parameters;
  const auto n = static_cast<double>(y.size());
  const double mean = std::accumulate(y.begin(), y.end(), 0.0) / n;
  for (std::size_t i = 0; i < y.size(); ++i) {
    figures.sse += (y[i] - f[i]) * (y[i] - f[i]);
    figures.sst += (y[i] - mean) * (y[i] - mean);
  }
  figures.rmse = std::sqrt(figures.sse / n);
  if (figures.sst > 0) {
    const double r2 = 1 - figures.sse / figures.sst;
    if (std::isfinite(r2)) figures.r2 = r2;
  }
  if (y.size() > parameters) {
    const double freedom = n - static_cast<double>(parameters);
    figures.rmse_freedom = std::sqrt(figures.sse / freedom);
    if (figures.r2) figures.adjusted_r2 = 1 - (1 - *figures.r2) * (n - 1) / freedom;
  }
  return figures;
}

}  // namespace abbe
