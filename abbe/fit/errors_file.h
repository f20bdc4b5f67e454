#pragma once

#include <string>

#include "abbe/fit/fit_job.h"
#include "abbe/fit/joint_fit.h"
#include "abbe/fit/thermal_fit.h"

namespace abbe {

/// The errors file of a fit (docs/machine-file.md, a separate errors file): what was found, in um and urad
/// over mm and deg, with [calibration], [uncertainty] and comments that say where it comes from. Thermal
/// errors are sums over sensors, each with the range of temperatures it was fitted in as its domain; lagged
/// ones stand in [sensors]. laws     ReadsBack
[[nodiscard]] std::string write_errors_file(const FitJob& job, const FitResult& result,
                                            const ThermalFit& thermal = {});

/// The covariance of all errors of a fit as [[uncertainty_mode]] tables to be added to its errors file; that
/// of thermal slopes likewise, each lagged temperature of the errors file being a variable, and one mode more
/// for what the model of an error leaves beyond its slopes:
///
///   C = L L^T,   mode m = column m of L   (L lower triangular; shares below 1e-4 of an uncertainty are left
///   out)
///
/// laws     ModesAddUpToTheCovariance, ThermalSlopesAreUncertainTogether
[[nodiscard]] std::string write_uncertainty_modes(const FitJob& job, const FitResult& result,
                                                  const ThermalFit& thermal = {});

}  // namespace abbe
