#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/cl/interpreter.h"
#include "abbe/cl/pose_field.h"
#include "abbe/core/file.h"
#include "abbe/core/progress.h"
#include "abbe/core/rewrite_report.h"
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

/// Rewrites a CL file so that the machine's errors cancel: edits numbers of motion records, splits motions
/// only where needed, copies every other byte. The result is for the post-processor of this machine.
///
/// laws    ZeroErrorsChangeNoByte
/// cost    constant memory whatever the length
/// source  docs/theory/cl-data.md
[[nodiscard]] RewriteReport rewrite_cl(const Plan& plan, const ClJob& job, SpoolFile& out,
                                       const Progress& progress = {});

}  // namespace abbe
