#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "abbe/chain/predict.h"
#include "abbe/core/progress.h"
#include "abbe/volume/grid.h"

namespace abbe {

/// Points per piece of work. Sums are made piece by piece, in order.
inline constexpr std::size_t kFieldChunk = 512;

/// The deviation at every point of a grid, in the order of the grid. Deviations are actual - nominal in
/// workpiece axes, as of abbe::predict.
struct DeviationField {
  std::vector<Vec3> nominal;                    ///< tip, mm
  std::vector<Vec3> nominal_axis;               ///< of the tool, from the tip to the spindle
  std::vector<Vec3> deviation;                  ///< of the tip, mm
  std::vector<Vec3> rotation;                   ///< of the tool: rotation vector of R_actual R_nominal^T, rad
  std::vector<double> tilt;                     ///< angle between actual and nominal tool axis, rad
  std::vector<char> extrapolated;               ///< 1: some error was held beyond its ends
  std::vector<std::string> extrapolated_names;  ///< at some point, in file order
  bool finite = true;    ///< false: the numbers of some point are too large; the field is then empty
  bool complete = true;  ///< false: stopped by the progress callback; the field is then empty
};

/// How a volume is looked at.
struct FieldCircumstances {
  std::array<signed char, kMaxAxes> approach{};  ///< 0: mean of both directions
  Tool tool;
  unsigned threads = 0;  ///< 0: one per processor; the result does not depend on it
};

/// laws     FieldIsPredictAtEveryPoint, SameForAnyNumberOfThreads
/// cost     one prediction per point on all processors; 110 bytes per point
[[nodiscard]] DeviationField deviation_field(const Plan& plan, const VolumeGrid& grid,
                                             const FieldCircumstances& circumstances,
                                             const Progress& progress = {}, std::size_t done_before = 0,
                                             std::size_t total = 0);

/// Angle between two tool axes of any length, exact when small.
[[nodiscard]] double angle_between(const Vec3& a, const Vec3& b);

/// The chunks of a grid: number of them, and the points [first, last) of one.
[[nodiscard]] std::size_t chunk_count(std::size_t points);
struct ChunkRange {
  std::size_t first = 0, last = 0;
};
[[nodiscard]] ChunkRange chunk_range(std::size_t chunk, std::size_t points);

}  // namespace abbe
