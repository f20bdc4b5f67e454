#pragma once

#include <cstdint>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/core/progress.h"
#include "abbe/machine/uncertainty_modes.h"
#include "abbe/volume/map.h"

namespace abbe {

/// 95 % of a normal distribution lie within this many standard deviations.
inline constexpr double kCoverage95 = 1.959963984540054;

/// More numbers than this are refused: points times trials.
inline constexpr std::size_t kMostDraws = 200'000'000;

struct UncertaintyQuestion {
  VolumeQuestion volume;
  Environment environment;
  std::size_t trials = 1000;  ///< of Monte Carlo; 0: first order only
  std::uint64_t seed = 1;
};

/// A figure of the volume as it is drawn.
struct DrawnFigure {
  double value = 0;          ///< of the errors as stated
  double mean = 0, u = 0;    ///< over the trials
  double low = 0, high = 0;  ///< 95 % of the trials, as many left out below as above
};

/// How uncertain the deviation is at every point of a grid, in its order. mm; u: standard uncertainties along
/// x y z.
struct VolumeUncertainty {
  enum class Status { done, stopped, overflow, missing_sensor } status = Status::done;
  std::vector<Vec3> u;             ///< first order
  std::vector<Vec3> u_from_datum;  ///< first order, of the deviation minus that at the datum
  std::vector<Vec3> u_drawn;       ///< Monte Carlo; empty without trials
  DrawnFigure max, rms;            ///< of the distance of the tip from where it should be
};

/// First order (JCGM 100) and Monte Carlo (JCGM 101) of the modes z ~ N(0, 1):
///
///   u^2(q) = sum_m d_m(q)^2,   d_m: first-order deviation by mode m alone                      (1)
///   draw k: rigid model of errors + sum_m z_mk mode_m at every point; figures of each draw      (2)
///
/// Each draw has a generator of its own, seeded by its number, so that threads do not matter.
///
/// laws     FirstOrderAgreesWithMonteCarlo, ClosedFormOfSquareness, SameForAnyNumberOfThreads,
/// SameSeedSameNumbers cost     a prediction per point and mode, then per point and trial, on all processors
[[nodiscard]] VolumeUncertainty volume_uncertainty(const Machine& machine, const UncertaintyModes& modes,
                                                   const UncertaintyQuestion& question,
                                                   const Progress& progress = {});

}  // namespace abbe
