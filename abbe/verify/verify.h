#pragma once

#include <cstddef>
#include <string>

#include "abbe/chain/plan.h"
#include "abbe/core/file_growth.h"
#include "abbe/core/progress.h"
#include "abbe/core/units.h"
#include "abbe/core/verify_report.h"
#include "abbe/machine/control_setup.h"

namespace abbe {

/// probed: the work offset was touched off on this machine, so the deviation at its origin belongs to
/// the part's position and is subtracted. ideal: work offsets are true.
enum class DatumRule { probed, ideal };

struct VerifyJob {
  std::string original_path, output_path;  ///< files to read
  std::string original_name, output_name;  ///< what diagnostics call them
  ControlSetup setup;
  DatumRule datum = DatumRule::probed;
  bool reversal = false;                ///< direction-dependent errors by direction, not by their mean
  double tolerance = 1 * um;            ///< mm: interpolation and solution
  double max_correction = 500 * um;     ///< mm: a commanded point may not move farther than this
  double block_time = 0;                ///< least time of a piece of a split motion, s; 0: any
  std::size_t samples = 0;              ///< points to keep for figures, spread over the path; 0 = none
  bool one_by_one = false;              ///< no motions are judged together: slower, the same verdict
  FileGrowth* output_growth = nullptr;  ///< of an output that is still being written
};

/// Reads both programs with a reader that shares only number parsing with the rewriter, pushes the
/// output through the forward model and compares it with the original's nominal path: densely along
/// every feed motion, at the end of every rapid, all other events one by one.
/// cost    constant memory whatever the length
/// source  docs/theory/verification.md
[[nodiscard]] VerifyReport verify_program(const Plan& plan, const VerifyJob& job,
                                          const Progress& progress = {});

}  // namespace abbe
