#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/gear/flank_tolerances.h"
#include "abbe/gear/gear_file.h"

namespace abbe {

/// What a gear chart shows.
struct GearChart {
  struct Tooth {
    int number = 1;                     ///< from 1
    std::array<FlankTraces, 2> traces;  ///< right, left
  };
  std::string title, remark;
  std::vector<Tooth> teeth;  ///< at most kMostChartTeeth are drawn
  GearFigures figures;       ///< of all teeth
};
inline constexpr std::size_t kMostChartTeeth = 6;

/// The chart of a gear as measuring machines print it, one page that prints in black and white as well:
///
///   profile   a trace per tooth, left flanks on the left and right flanks on the right; the roll length goes
///   up from
///             form to tip, excess material goes away from the gap between them; evaluation range, mean line,
///             figures
///   helix     the same over the face
///   pitch     cumulative pitch of all teeth and single pitch as bars, left and right flanks
///   runout    of a ball in every gap
///
/// with tolerances of the job's class where it has one. All traces have one scale, a round number of um per
/// division.
///
/// errors   none; a chart without teeth shows pitch and runout
/// laws     SameInputSameBytes, WellFormed
[[nodiscard]] std::string figure_of_gear(const GearJob& job, const GearChart& chart);

}  // namespace abbe
