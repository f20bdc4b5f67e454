#pragma once

#include <cstddef>
#include <vector>

#include "abbe/volume/field.h"

namespace abbe {

/// What one error of the machine file does to the tip over a grid, all other errors off:
///
///   d_i(q) = tip with error i alone - nominal tip
///
/// Shares do not add up to the whole: deviations are vectors that may cancel (and rms values add as squares
/// at best). What correcting one error would gain is therefore given as well, as the rms of d - d_i: exact to
/// the first order in the errors, as far as the whole is the sum of the d_i.
struct ErrorShare {
  std::size_t error = 0;              ///< index in Machine::errors
  double max = 0, rms = 0;            ///< of |d_i|, mm
  std::size_t at = 0;                 ///< the point of the largest |d_i|
  Vec3 rms_component = Vec3::Zero();  ///< of d_i along x y z, mm
  double max_tilt = 0;                ///< of the tool axis, rad
  std::size_t at_tilt = 0;
  double rms_without = 0;  ///< of |d - d_i|, mm
};

/// The shares of all errors, the largest rms first; of equal ones in file order. `field` is that of the same
/// plan, grid and circumstances. Empty if `progress` asked to stop.
///
/// laws     OneErrorIsTheWholeBudget, SameForAnyNumberOfThreads
/// cost     one tip per error and point on all processors
[[nodiscard]] std::vector<ErrorShare> error_budget(const Plan& plan, const VolumeGrid& grid,
                                                   const FieldCircumstances& circumstances,
                                                   const DeviationField& field, const Progress& progress = {},
                                                   std::size_t done_before = 0, std::size_t total = 0);

/// Lost motion of an axis over a grid: the deviation after it came from below minus that after it came from
/// above, the other axes at the mean of both directions.
struct LostMotion {
  int axis = 0;
  double max = 0, rms = 0;  ///< of the length of that vector, mm
  std::size_t at = 0;
};

/// Moving axes on whose direction of approach some error depends, increasing.
[[nodiscard]] std::vector<int> directional_axes(const Machine& machine);

/// One entry per directional axis. Empty also if `progress` asked to stop.
[[nodiscard]] std::vector<LostMotion> lost_motion(const Plan& plan, const VolumeGrid& grid,
                                                  const FieldCircumstances& circumstances,
                                                  const Progress& progress = {}, std::size_t done_before = 0,
                                                  std::size_t total = 0);

}  // namespace abbe
