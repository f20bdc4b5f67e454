#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "abbe/chain/plan.h"
#include "abbe/compensate/rewrite.h"
#include "abbe/machine/control_setup.h"
#include "abbe/machine/machine.h"
#include "abbe/verify/verify.h"

namespace abbe {

/// Everything known about one run of compensate, check or verify: what its reports are made from.
/// Nothing here depends on the clock, so the same run gives the same reports.
struct ProgramReport {
  std::string verb;                        ///< "compensate", "check", "verify"
  std::string program_version;             ///< "0.1.0"
  std::string input_name, output_name;     ///< as the user gave them; output empty: none was published
  const Machine* machine = nullptr;        ///< never null
  const RewriteReport* rewrite = nullptr;  ///< null for verify
  const VerifyReport* verify = nullptr;    ///< null if the program was refused before
  ErrorModel model = ErrorModel::rigid;
  Environment environment;
  ControlSetup setup;
  std::string dialect = "linuxcnc";
  DatumRule datum = DatumRule::probed;
  bool reversal = false;
  double tolerance = 0;       ///< mm
  double max_correction = 0;  ///< mm
  std::optional<double>
      limit;  ///< mm: --limit-um; `pass` says whether the largest remaining deviation keeps it
};

/// How the run ended, in one word for reports.
enum class ProgramResult { verified, refused, outside, disagrees, stopped };
[[nodiscard]] ProgramResult result_of(const ProgramReport& report);
[[nodiscard]] std::string_view to_string(ProgramResult result);

/// "G54" .. "G59.3" of the work offset with that index (the inverse of work_offset_index).
[[nodiscard]] std::string_view work_offset_name(std::size_t index);

/// The report for programs (docs/report.md lists every member): lengths in um or mm as the names say.
[[nodiscard]] std::string json_report(const ProgramReport& report);

/// The few lines for the person who waits: what was wrong, what is left, where to look.
[[nodiscard]] std::string human_report(const ProgramReport& report);

}  // namespace abbe
