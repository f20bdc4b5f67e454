#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "abbe/volume/budget.h"
#include "abbe/volume/diagonals.h"
#include "abbe/volume/field.h"
#include "abbe/volume/grid.h"
#include "abbe/volume/statistics.h"

namespace abbe {

/// More points than this are refused: a map keeps all of them (about 110 bytes each).
inline constexpr std::size_t kMostMapPoints = 4'000'000;

struct VolumeQuestion {
  VolumeGrid grid;
  std::array<double, kMaxAxes> datum{};  ///< axis positions, mm or rad
  FieldCircumstances circumstances;
};

/// Everything `abbe map` says about a volume (docs/theory/volume.md).
struct VolumeMap {
  enum class Status { done, stopped, overflow } status = Status::done;  ///< not done: the rest is empty
  DeviationField field;
  FieldFigures figures;     ///< of the deviations as predicted
  Amount tilt;              ///< of the tool axis, rad
  Alignment datum;          ///< the deviation at the datum, as a displacement
  FieldFigures from_datum;  ///< of what is left when that is taken away
  Alignment fit;
  FieldFigures fitted;  ///< of what is left of the best fit
  VolumetricAccuracy accuracy, fitted_accuracy;
  std::vector<Diagonal> diagonals;
  std::vector<ErrorShare> budget;
  std::vector<LostMotion> lost_motion;
  std::size_t extrapolated = 0;  ///< points at which some error was held beyond its ends
};

/// laws     SameForAnyNumberOfThreads
/// errors   a grid of 0 or more than kMostMapPoints points is the caller's mistake (assert)
[[nodiscard]] VolumeMap map_volume(const Plan& plan, const VolumeQuestion& question,
                                   const Progress& progress = {});

}  // namespace abbe
