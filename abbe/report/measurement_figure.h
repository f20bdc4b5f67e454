#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "abbe/evaluate/drift.h"
#include "abbe/evaluate/measured_table.h"
#include "abbe/evaluate/positioning.h"
#include "abbe/evaluate/run_table.h"

namespace abbe {

/// A line of text beside the picture: "E", "15.99 um".
struct FigureFact {
  std::string name, value;
};

/// The picture of runs along an axis, one page that prints in black and white as well: every reading as a
/// dot, the means of both directions of approach as lines (backward dashed), with what is known as facts
/// beside it.
///
/// errors   none
/// laws     SameInputSameBytes, WellFormedForAnyRuns
/// cost     the file grows with the readings, of which at most 5000 are drawn
[[nodiscard]] std::string figure_of_runs(const RunTable& table, std::string_view title,
                                         const std::vector<FigureFact>& facts);

/// The picture of a drift test: every sensor over time, lengths, angles and temperatures on scales of their
/// own. `table` has passed drift_figures.
[[nodiscard]] std::string figure_of_drift(const MeasuredTable& table, std::string_view title,
                                          const std::vector<FigureFact>& facts);

}  // namespace abbe
