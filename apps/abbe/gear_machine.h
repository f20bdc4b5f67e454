#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/gear/machine_cut.h"
#include "command_line.h"
#include "common.h"
#include "gear.h"

namespace abbe::app {

/// Options of the kinds of `gear` that need a machine, as typed.
struct GearMachineArguments {
  CommonArguments common;
  std::string gear, course;
  std::vector<std::string> near;
  int nodes = 33;
};
void add_gear_machine_options(Command& command, GearMachineArguments& arguments, Session& session);

/// A gear on a machine: everything read, and the nominal commands.
struct GearOnMachine {
  Setting setting;
  LoadedGear gear;
  CuttingMotion motion;
  SensorCourse course;
  std::vector<std::string> inputs;  ///< files that were read
};

/// nullopt after reporting all mistakes: E-GEAR-AXES where the chain cannot hold the wheel, E-TRAVEL where
/// the travels end, E-GEAR-COURSE for a course without times, E-SENSOR. W-GEAR-COURSE for one
/// that begins after the first gap or ends before the last one.
[[nodiscard]] std::optional<GearOnMachine> load_gear_on_machine(const GearMachineArguments& arguments,
                                                                Session& session);

/// E-GEAR-AXES or E-TRAVEL.
void report_cutting(const CuttingProblem& problem, const GearMachineArguments& arguments, Session& session);

/// "none", "pose" or "flank".
[[nodiscard]] CutCorrection correction_of(std::string_view text);

/// E-VOL: a correction would rest on errors nobody has measured.
void report_outside(const std::string& file, Session& session);

/// False after E-TRAVEL: the first of these commands (as motions_csv takes them) that an axis cannot reach.
[[nodiscard]] bool within_travels(const GearOnMachine& loaded, const std::vector<AxisCommands>& commands,
                                  Session& session);

/// W-GEAR-LARGE where what first order neglects (second_order of exact_cut.h) is much, or cannot be computed.
void report_second_order(const std::optional<double>& neglected, const std::string& file, Session& session);

/// Commands of every gap and place as CSV: heights above the middle of the face, seconds, axes in the machine
/// file's units.
[[nodiscard]] std::string motions_csv(const GearOnMachine& loaded, const std::vector<AxisCommands>& commands);

/// Options of a cut without correction.
[[nodiscard]] CutOptions cut_options(const GearOnMachine& loaded);

}  // namespace abbe::app
