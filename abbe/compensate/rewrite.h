#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/core/file.h"
#include "abbe/core/progress.h"
#include "abbe/core/rewrite_report.h"
#include "abbe/core/units.h"
#include "abbe/machine/control_setup.h"

namespace abbe {

struct RewriteJob {
  std::string path;  ///< program to read
  std::string name;  ///< what diagnostics call it
  ControlSetup setup;
  bool probed_datum = true;
  bool reversal = false;
  double tolerance = 1 * um;         ///< mm; half of it is spent on interpolation
  double max_correction = 500 * um;  ///< mm
  double max_gradient = 1e-3;        ///< mm per mm
  bool expand_drill = false;         ///< G81 and G82 that cannot be shifted as a whole become G0, G1 and G4
  double block_time = 0;             ///< no split makes a feed block that lasts shorter, s; 0: any
  std::vector<std::string> header;   ///< comment lines to put at the top, after '%' and the O word
  std::uint64_t trace_line = 0;      ///< explain this line of the program; 0 = none
  bool one_by_one = false;           ///< no lines are corrected together: slower, the same output
};

/// Rewrites a program so that the machine's errors cancel: edits the digits of coordinate words, adds
/// words or blocks only where needed, copies every other byte. Lines go to `out` in order.
/// cost    constant memory whatever the length
/// source  docs/theory/compensation.md
[[nodiscard]] RewriteReport rewrite_program(const Plan& plan, const RewriteJob& job, SpoolFile& out,
                                            const Progress& progress = {});

}  // namespace abbe
