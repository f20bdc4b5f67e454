#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/evaluate/measured_table.h"

namespace abbe {

/// What one sensor of a drift test saw. Ranges are largest minus smallest reading.
struct SensorDrift {
  std::string name;
  Quantity quantity = Quantity::length;
  double range = 0;             ///< over the whole test
  double range_first_hour = 0;  ///< over the first 60 min
  double most_in_an_hour = 0;   ///< largest range over any 60 min
  double change = 0;            ///< last minus first reading
};

struct DriftFigures {
  double duration = 0;  ///< s
  std::vector<SensorDrift> sensors;
};

/// Figures in the manner of ISO 230-3:2020 (environmental temperature variation error, distortion by spindle
/// or axes): the ranges of every sensor. The table has a column `time` in s, min or h; all other columns with
/// a unit are sensors. With `sensor_distance` (mm) the parallel sensors Y1, Y2 and X1, X2 also give the tilts
///
///   A = (Y1 - Y2) / distance,  B = (X2 - X1) / distance
///
/// errors   E-DRIFT-TIME (no such column, or time does not increase), E-DRIFT-SENSOR (no sensor)
/// laws     RangesOfARamp, TiltOfParallelSensors
/// cost     O(rows * sensors)
/// source   ISO 230-3 as remembered by practice, not by the text (docs/theory/measurement.md)
[[nodiscard]] Parsed<DriftFigures> drift_figures(const MeasuredTable& table,
                                                 std::optional<double> sensor_distance = std::nullopt);

}  // namespace abbe
