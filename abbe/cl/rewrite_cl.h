#pragma once

#include <array>
#include <cstdint>
#include <optional>
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

/// A CL file and how it is to be read and corrected.
struct ClJob {
  std::string path, name;  ///< the file, and what findings call it
  ControlSetup setup;      ///< G54 places the program on the machine; tools, gauge lengths
  cl::Conventions conventions;
  cl::Commands start{};  ///< where the machine stands: decides the branch of the first pose
  bool probed_datum = true;
  double tolerance = 1 * um;         ///< mm; half of it is spent on interpolation
  double max_correction = 500 * um;  ///< mm, of the tip
  double max_gradient = 1e-3;        ///< mm per mm
  std::vector<std::string> header;   ///< lines of text, written as remarks at the top
  std::uint64_t trace_line = 0;      ///< explain this line; 0 = none
};

/// What happened to one record, for `abbe explain`.
struct ClTrace {
  std::optional<int> tool;
  double gauge_length = 0;                                 ///< mm
  Vec3 frame_origin = Vec3::Zero(), datum = Vec3::Zero();  ///< mm
  cl::ToolPose start, end, written;                        ///< program frame
  cl::Commands commanded{}, corrected{};                   ///< of the axes, for the end
  std::string decision, before, after;
};

struct ClReport {
  bool complete = false;  ///< false: refused or stopped, the output is worthless
  bool stopped = false;
  Diagnostics diagnostics;
  FileIdentity identity;
  std::uint64_t lines_in = 0, bytes_in = 0, lines_out = 0;
  std::uint64_t motions = 0, rewritten = 0, split = 0, passed = 0;
  std::uint64_t arcs_in = 0, arcs_out = 0;
  std::array<double, 3> max_correction{};  ///< of the tip, per X Y Z of the program, mm
  std::array<std::uint64_t, 3> max_line{};
  double max_turn = 0;         ///< largest change of a tool axis, rad
  double max_gradient = 0;     ///< mm per mm
  double cycle_residual = 0;   ///< mm, inside cycles (rigid shift)
  double shortest_split = 0;   ///< mm, 0 = nothing split
  std::uint64_t singular = 0;  ///< poses whose axis was kept near the singularity
  std::optional<ClTrace> trace;
  bool compensated_input = false;
  bool out_of_volume = false;
};

/// Rewrites a CL file so that the machine's errors cancel: edits numbers of motion records, splits motions
/// only where needed, copies every other byte. The result is for the post-processor of this machine. laws
/// ZeroErrorsChangeNoByte cost    constant memory whatever the length source  docs/theory/cl-data.md
[[nodiscard]] ClReport rewrite_cl(const Plan& plan, const ClJob& job, SpoolFile& out,
                                  const Progress& progress = {});

}  // namespace abbe
