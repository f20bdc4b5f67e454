#pragma once

#include <map>
#include <string>
#include <variant>
#include <vector>

#include "abbe/chain/correct.h"
#include "abbe/core/progress.h"
#include "abbe/gear/cutting_motion.h"

namespace abbe {

/// Sensors over the time of the cut: between two times linear, before and after the ends held. Values in the
/// units of the machine file.
struct SensorCourse {
  std::vector<double> time;  ///< s, increasing
  std::map<std::string, std::vector<double>, std::less<>> values;

  /// `fixed` with the sensors at that time, and `t`.
  [[nodiscard]] Environment at(double time_s, const Environment& fixed) const;
};

/// Which commands the machine is sent.
enum class CutCorrection {
  none,   ///< nominal ones
  pose,   ///< those that bring the wheel to its pose (correct.h): position and direction
  flank,  ///< those that leave the least deviation on both flanks, with the axes there are
};

struct CutOptions {
  CutCorrection correction = CutCorrection::none;
  AxisSet free = 0;       ///< axes that a correction may move
  CorrectOptions solver;  ///< of `pose`
  /// Commands in place of the motion's own, as many; null: those. `pose` corrects them, `flank` does not know
  /// them.
  const std::vector<AxisCommands>* sent = nullptr;
  /// Deviations known from elsewhere (measured flanks), at the motion's places: `flank` makes up for them
  /// too.
  const WheelDeviations* known = nullptr;
  ErrorModel model = ErrorModel::rigid;
  Environment environment;
  SensorCourse course;
};

/// What a machine with errors did.
struct MachineCut {
  WheelDeviations deviations;          ///< of the wheel from its nominal pose, axes of the gaps
  std::vector<AxisCommands> commands;  ///< sent, as CuttingMotion orders them
  bool outside = false;                ///< an error was held beyond its measured ends
  bool stopped = false;                ///< by `progress`; the rest is then empty
  std::size_t partial = 0;             ///< places where an axis was missing, or held, for part of the position
  std::size_t failed = 0;              ///< places without a correction: nominal commands
};

/// Sends the motion through a machine with errors, at the temperatures of each moment.
///
///     d = p_actual(q') - p_nominal(q),   [e]x = antisymmetric part of R_actual(q') R_nominal(q)^T
///     flank: dq = argmin over both flanks |W ((d, e) + J dq)|
///
/// errors   MissingSensors
/// laws     NominalMachineHasNoDeviation, PoseCorrectionRemovesEverything, FlankCorrectionIsNeverWorse
/// cost     two poses per gap and node, with a correction some ten; one plan per place where a sensor changes
///          with time
/// source   docs/theory/gears.md, section 5 and (13)
[[nodiscard]] std::variant<MachineCut, MissingSensors> cut_on_machine(
    const Machine& machine, const GearJob& job, const WheelInGap& wheel, const CuttingMotion& motion,
    const CutOptions& options, const Progress& progress = {});

}  // namespace abbe
