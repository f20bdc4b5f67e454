#pragma once

#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "common.h"
#include "pose_source.h"
#include "program_options.h"

namespace abbe::app {

/// inverse --emit gcode: what it takes besides the options of inverse, as typed.
struct GcodeArguments {
  std::string emit, profile = "linuxcnc", output, units;
  std::vector<std::string> offsets, gauges;
  std::string tools, datum = "probed";
  std::optional<double> feed;
  double tolerance_um = 1, max_correction_um = 500;
  ClArguments cl;
};

void add_gcode_options(Command& verb, GcodeArguments& arguments);

/// Writes the program of the poses (CL data or CSV).
void write_gcode(const CommonArguments& common, const PoseArguments& poses, bool ideal,
                 const GcodeArguments& arguments, Session& session);

}  // namespace abbe::app
