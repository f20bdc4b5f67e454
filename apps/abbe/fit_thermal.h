#pragma once

#include <optional>
#include <string>

#include "abbe/fit/fit_job.h"
#include "abbe/fit/thermal_fit.h"
#include "abbe/report/json_writer.h"
#include "session.h"

namespace abbe::app {

/// The thermal part of a job (nothing in it if the job has no logs); nullopt after reporting why there is
/// none.
[[nodiscard]] std::optional<ThermalFit> thermal_or_report(const FitJob& job, Session& session);

/// What the numbers say against themselves.
void report_thermal_doubts(const FitJob& job, const ThermalFit& fit, Session& session);

[[nodiscard]] std::string thermal_text(const FitJob& job, const ThermalFit& fit);
/// A member "thermal" of the object that is open.
void write_thermal(JsonWriter& json, const FitJob& job, const ThermalFit& fit);

}  // namespace abbe::app
