#pragma once

#include <vector>

namespace abbe {

/// What a body of one time constant makes of a temperature that is straight between its samples:
///
///   tau dy/dt + y = u(t),   y(t_0) = u(t_0)
///   y_k = u_k - m tau + (y_(k-1) - u_(k-1) + m tau) exp(-h / tau),   h = t_k - t_(k-1), m = (u_k - u_(k-1))
///   / h
///
/// exactly, whatever the steps. The record is taken to begin in equilibrium: what was before it is forgotten
/// after some 3 tau.
///
/// shapes   as many times (increasing, s) as values; tau >= 0 in s, 0 gives the values themselves
/// laws     StepAnswerIsExponential, RampLagsBehindByTau, ZeroLagChangesNothing
/// cost     one exponential per sample
[[nodiscard]] std::vector<double> first_order_lag(const std::vector<double>& times,
                                                  const std::vector<double>& values, double tau);

}  // namespace abbe
