#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/fit/fit_job.h"
#include "abbe/simulate/measurements.h"

namespace abbe {

/// How long a machine is watched and how well.
struct DriftScenario {
  double duration = 6 * 3600, step = 60;           ///< s
  double length = 0.3 * um, angle = 0.5 * arcsec;  ///< noise of readings
  double temperature = 0.02;                       ///< K, of sensors
  double start = 20;                               ///< degC: everything is in equilibrium when it begins
};

/// Logs of a machine that does not exist: it works at changing loads and rests; every sensor follows the load
/// with a time constant (5 to 90 min) and a rise of its own (3 to 16 K), drawn once for all logs, and the
/// hall by +-0.5 K in a day. At every step `hidden` is asked by its rigid model what the readings of each
/// planned log (plan_fit_job) see; its lagged sensors follow the true temperatures, not the noisy ones.
///
/// errors   empty if `hidden` needs a sensor that the job does not name
/// laws     FitFindsTheHiddenDrift, SameSeedSameLogs
/// cost     one plan and one prediction per reading and step
[[nodiscard]] std::vector<SimulatedFile> simulate_drift(const FitJob& job, const Machine& hidden,
                                                        const DriftScenario& scenario, std::uint64_t seed);

}  // namespace abbe
