#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/fit/fit_job.h"
#include "abbe/simulate/measurements.h"
#include "session.h"

namespace abbe::app {

/// The job of `fit` before anything was measured; nullopt after reporting what is wrong with it.
[[nodiscard]] std::optional<FitJob> planned_job(const std::string& path, const MeasurementPlan& plan,
                                                Session& session);

/// The job's machine with the hidden errors; nullopt after reporting.
[[nodiscard]] std::optional<Machine> hidden_machine(const FitJob& job, const std::string& errors,
                                                    Session& session);

/// Writes all files or none. One that is there already may be a real measurement: refused without `force`.
[[nodiscard]] bool publish_simulated(const std::vector<SimulatedFile>& files, bool force, Session& session);

}  // namespace abbe::app
