#pragma once

#include <optional>
#include <string>

#include "abbe/chain/plan.h"
#include "abbe/cl/interpreter.h"
#include "abbe/cl/pose_field.h"
#include "abbe/compensate/rewrite.h"
#include "abbe/core/diagnostic.h"
#include "abbe/core/progress.h"
#include "abbe/machine/control_setup.h"
#include "abbe/report/program_report.h"
#include "abbe/verify/verify.h"

namespace abbe {

/// Where a compensated program says what it is: as comments in it, in a file beside it, or nowhere.
enum class HeaderForm { inline_comments, sidecar, none };

/// What is asked of CL data besides.
struct ClSetting {
  cl::Conventions conventions;
  cl::Commands start{};  ///< where the machine stands: decides the branch of the first pose
};

/// A program, the machine it runs on, and what is wanted.
struct ProgramJob {
  std::string program;  ///< path, or "-" for standard input
  std::string output;   ///< path, "-" for standard output, empty: check only
  ErrorModel model = ErrorModel::rigid;
  Environment environment;
  ControlSetup setup;
  DatumRule datum = DatumRule::probed;
  bool reversal = false;
  double tolerance = 1 * um;         ///< mm
  double max_correction = 500 * um;  ///< mm
  bool expand_drill = false;         ///< RewriteJob::expand_drill
  double block_time = 0;             ///< RewriteJob::block_time, s
  std::optional<double> limit;       ///< mm: pass or fail of what is left
  HeaderForm header = HeaderForm::inline_comments;
  std::string report, figure;    ///< paths; empty: none
  std::string version;           ///< of this program, for header and report
  std::string today;             ///< YYYY-MM-DD, to hold against [calibration] valid_to; empty: not checked
  std::uint64_t trace_line = 0;  ///< explain this line
  unsigned threads = 0;         ///< 1: verify after rewriting; else at the same time, if there are processors
  std::optional<ClSetting> cl;  ///< the program is CL data (APT, CLSF), not G code
};

enum class ProgramEnd { done, io, invalid, refused, outside, disagrees, stopped };

struct ProgramOutcome {
  ProgramEnd end = ProgramEnd::io;
  Diagnostics diagnostics;  ///< everything found, in order
  RewriteReport rewrite;
  VerifyReport verify;
  std::string json, text;  ///< the report, for programs and for people; empty if nothing could be read
};

/// The whole way of one program: read and rewrite into a spool file, verify the spooled text with the
/// independent reader, and only then publish the output, the report and the figure.
/// With two threads the verification follows the rewriter through the spool file; what comes out is the same.
/// errors   see ProgramEnd; nothing is published unless `done`, the input is never written to
/// cost     constant memory whatever the length
/// source   docs/architecture.md, the way of a program
[[nodiscard]] ProgramOutcome compensate_program(const Plan& plan, const ProgramJob& job,
                                                const Progress& progress = {});

/// The verification alone, of two existing files.
[[nodiscard]] ProgramOutcome verify_programs(const Plan& plan, const ProgramJob& job,
                                             const std::string& output, const Progress& progress = {});

}  // namespace abbe
