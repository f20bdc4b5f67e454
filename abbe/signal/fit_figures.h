#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "abbe/signal/result.h"

namespace abbe {

/// How well a curve describes a record of n samples with m fitted parameters.
///
///   SSE = sum (y - f)^2,  SST = sum (y - mean y)^2,  R2 = 1 - SSE / SST
///   RMSE = sqrt(SSE / n)   or, as MATLAB prints it,   RMSE = sqrt(SSE / (n - m))
///   adjusted R2 = 1 - (1 - R2) (n - 1) / (n - m)
struct FitFigures {
  std::size_t samples = 0, parameters = 0;
  double sse = 0, sst = 0;
  double rmse = 0;                     ///< of n
  std::optional<double> rmse_freedom;  ///< of n - m; none if n <= m
  std::optional<double> r2;            ///< none if y does not vary
  std::optional<double> adjusted_r2;   ///< none if one of the two above is none
};

/// y, f     equally many, at least 1, in the same unit
[[nodiscard]] SignalResult<FitFigures> fit_figures(std::span<const double> y, std::span<const double> f,
                                                   std::size_t parameters = 0);

}  // namespace abbe
