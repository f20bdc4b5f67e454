#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "abbe/chain/plan.h"
#include "abbe/cl/interpreter.h"
#include "abbe/core/file_growth.h"
#include "abbe/core/progress.h"
#include "abbe/core/units.h"
#include "abbe/core/verify_report.h"
#include "abbe/machine/control_setup.h"

namespace abbe {

struct ClVerifyJob {
  std::string original_path, output_path;  ///< files to read
  std::string original_name, output_name;  ///< what findings call them
  ControlSetup setup;
  cl::Conventions conventions;
  std::array<double, kMaxAxes> start{};
  bool probed_datum = true;
  double tolerance = 1 * um;            ///< mm: interpolation and solution
  double max_correction = 500 * um;     ///< mm, of the tip
  std::size_t samples = 0;              ///< points to keep for figures; 0 = none
  FileGrowth* output_growth = nullptr;  ///< of an output that is still being written
};

/// Reads both CL files with a reader that shares only number parsing with the rewriter's, turns the output
/// into commands as an ideal post-processor does, pushes them through the model with all errors, and compares
/// the tip with the original's path: densely along feed motions, at the ends of rapids, at depth and
/// clearance of holes. All other records must be the same, byte for byte and in the same order: they are the
/// report's events. Directions of the tool axis are those at the ends of motions.
///
/// errors  V-... disagreements (20 at most), E-... records that are not understood
/// cost    constant memory whatever the length
/// source  docs/theory/cl-data.md
[[nodiscard]] VerifyReport verify_cl(const Plan& plan, const ClVerifyJob& job, const Progress& progress = {});

}  // namespace abbe
