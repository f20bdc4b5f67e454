#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/cl/interpreter.h"
#include "abbe/cl/pose_field.h"
#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"
#include "abbe/core/progress.h"
#include "abbe/core/units.h"
#include "abbe/machine/control_setup.h"

namespace abbe {

/// CL data that become axis words of a LinuxCNC program: Abbe as the last stage of a post-processor.
struct GcodeJob {
  std::string path, name;  ///< the CL file, and what findings call it
  ControlSetup setup;      ///< G54: its offset is taken off the words; tools, gauge lengths
  cl::Conventions conventions;
  cl::Commands start{};  ///< where the machine stands: decides the branch
  bool ideal = false;    ///< of the ideal machine: errors ignored
  bool probed_datum = true;
  double tolerance = 1 * um;         ///< mm; half of it for the straightness of the tip's path
  double max_correction = 500 * um;  ///< mm, largest change of a linear axis
  std::vector<std::string> header;   ///< comment lines, brackets included
};

struct GcodeReport {
  bool complete = false;
  bool stopped = false;
  Diagnostics diagnostics;
  std::uint64_t motions = 0, blocks = 0, arcs = 0;
  double max_correction = 0;  ///< mm, of a linear axis
  double max_turn = 0;        ///< rad, of a rotary axis
  bool out_of_volume = false;
};

/// Writes G0 and G1 with the words of the machine's addresses, G21 G90 G49: the control adds G54 and no tool
/// length. Tips go straight: where the linear motion of all axes would leave the path, blocks are added; arcs
/// become lines. Feed: G94, along the tip; where rotary axes turn G93, so that the tip keeps its feed (a tip
/// at rest: the fastest rotary axis turns at as many degrees per minute). Events: SPINDL, COOLNT, LOADTL,
/// LOAD/TOOL, DELAY, STOP, OPSTOP, FINI, CYCLE/DRILL (as motions), text as comments; CUTCOM, other cycles and
/// what has no word of its own are refused. laws   TheTipFollowsTheOriginal, TheTipKeepsItsFeed errors E-...
/// in the report, each with its place source docs/cl-data.md, section Without a post-processor
[[nodiscard]] GcodeReport emit_gcode(const Plan& plan, const GcodeJob& job, SpoolFile& out,
                                     const Progress& progress = {});

}  // namespace abbe
