#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/fit/fit_job.h"
#include "abbe/fit/observations.h"
#include "abbe/machine/machine.h"

namespace abbe {

/// A file as an instrument would have written it.
struct SimulatedFile {
  std::string path, text;
};

/// How imperfect instruments are where the job does not say.
struct SimulatedNoise {
  double length = 0.3 * um, angle = 0.5 * arcsec;  ///< standard deviation of a reading without `noise`
  double alignment = 100 * urad;                   ///< of straightedges, squares and frames
};

/// Measures a machine that does not exist: what the instruments of a planned job (plan_fit_job) would read on
/// `hidden`, by its rigid model. Every reading has the noise of its entry; zeros, alignments, the scales and
/// angles of artefacts within their uncertainties and the frames of points are drawn once for each file.
///
/// `hidden` has the same chain as the job's machine.
/// laws     FitFindsTheHiddenMachine, SameSeedSameFiles
/// cost     one rigid prediction per target and direction
[[nodiscard]] std::vector<SimulatedFile> simulate_measurements(const FitJob& job, const Observations& planned,
                                                               const Machine& hidden,
                                                               const SimulatedNoise& noise,
                                                               std::uint64_t seed);

}  // namespace abbe
