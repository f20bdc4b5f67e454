#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "abbe/report/program_report.h"

namespace abbe {

/// The comment lines that make a rewritten program traceable to what it was made from, without
/// end-of-line bytes, to be put before its first block.
///
///   (ABBE COMPENSATED - DO NOT EDIT - DO NOT RE-COMPENSATE)
///   (ABBE 0.1.0 SRC PART.NGC LINES 5204 SHA256 9F3C77AB0012)
///   (ABBE MACHINE VMC850 ID 17 SHA256 77AB31C4D2E0)
///   ...
///
/// Every line starts with "(ABBE ", is one comment, at most 60 characters long, of capital
/// letters, digits, blanks and . , : / + - = only, so that any control shows it. The first line is the
/// mark by which a compensated program is known; such a program is never compensated again.
/// The lines depend on the inputs alone: the same run writes the same lines.
///
/// laws     EveryLineIsShortAndPlain, FirstLineIsTheMark, SameReportSameLines
[[nodiscard]] std::vector<std::string> header_lines(const ProgramReport& report);

}  // namespace abbe
