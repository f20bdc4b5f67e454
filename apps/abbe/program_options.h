#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/pipeline/compensate_program.h"
#include "cl_options.h"
#include "command_line.h"
#include "common.h"
#include "expansion_options.h"
#include "profile_options.h"
#include "session.h"

namespace abbe::app {

/// Options of the verbs that read programs, as typed (docs/command-line.md).
struct ProgramArguments {
  CommonArguments common;
  ProfileArguments profile;
  std::vector<std::string> offsets, gauges, radii, start;
  std::string tools, parameters, block_delete, tool_change = "moves", datum = "probed", header = "inline";
  std::optional<int> tool;
  double tolerance_um = 1, max_correction_um = 500;
  std::optional<double> min_block_time_ms;
  bool reversal = false, expand_drill = false;
  std::string report, figure;
  ClArguments cl;
  ExpansionArguments expansion;
};

void add_program_options(Command& verb, ProgramArguments& arguments, Session& session);

/// With --skew, --scale or --pitch the first file is not a machine: the files move up by one. False after
/// reporting that one is missing. `files`: where they were put, in the order of the command line.
[[nodiscard]] bool settle_files(CommonArguments& arguments, const std::vector<std::string*>& files,
                                Session& session);

/// A machine, its plan, and what the control knows; nullopt after reporting all mistakes.
struct ProgramSetting {
  Setting setting;
  Plan plan;
  ProgramJob job;  ///< without paths of program and output
};
/// `program`: its path tells CL data from G code where --dialect does not.
[[nodiscard]] std::optional<ProgramSetting> load_program_setting(const ProgramArguments& arguments,
                                                                 const std::string& program,
                                                                 Session& session);

}  // namespace abbe::app
