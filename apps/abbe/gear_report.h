#pragma once

#include <string>
#include <vector>

#include "abbe/gear/flank_tolerances.h"
#include "abbe/gear/gear_file.h"
#include "abbe/report/json_writer.h"

namespace abbe::app {

/// The largest of all teeth, magnitudes, with the tolerance and the class of each.
struct WorstFigure {
  const char* name;  ///< as in JSON: "F_alpha"
  double FlankTolerances::*which;
  double value;  ///< mm
};
[[nodiscard]] std::vector<WorstFigure> worst_of(const GearFigures& figures);

/// "4.15": micrometres, never -0.
[[nodiscard]] std::string um_text(double length, int decimals = 2);

/// Gear and wheel for people, and the member `gear` and `wheel`.
[[nodiscard]] std::string text_of_gear(const GearJob& job, const WheelInGap& wheel);
void write_gear(JsonWriter& json, const GearJob& job, const WheelInGap& wheel);

/// The teeth asked for (from 1; the gear file's if empty, and all if that is), row by row, then the worst of
/// all teeth.
[[nodiscard]] std::string text_of_figures(const GearJob& job, const GearFigures& figures,
                                          const std::vector<int>& teeth);
void write_figures(JsonWriter& json, const GearJob& job, const GearFigures& figures,
                   const std::vector<int>& teeth);

/// Teeth to show, from 1.
[[nodiscard]] std::vector<int> shown_teeth(const GearJob& job, const std::vector<int>& asked);

}  // namespace abbe::app
