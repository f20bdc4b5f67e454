#pragma once

#include <array>
#include <optional>
#include <vector>

#include "abbe/machine/axis_section.h"
#include "abbe/machine/function_reader.h"
#include "abbe/machine/machine.h"
#include "abbe/machine/toml_document.h"

namespace abbe {

/// What later checks need to know about the text of one error.
struct ErrorNotes {
  Mark mark;                                    ///< of its name
  std::optional<std::array<double, 2>> extent;  ///< see ReadFunction
};

struct ErrorSection {
  std::vector<ErrorTerm> terms;   ///< in file order
  std::vector<ErrorNotes> notes;  ///< one per term
};

/// Reads [errors] and [uncertainty]. `units` are those of the same file.
[[nodiscard]] ErrorSection read_errors(const TomlNode& root, const std::vector<Body>& bodies,
                                       const FileUnits& units, FunctionReader& functions, Findings& findings);

/// What the axes and the errors say together: errors_seen missing on the workpiece branch, errors that
/// an explicit order leaves out, straightness that contains the squareness stated beside it.
/// `machine` is complete but for its sha256; places of axes are in `machine_findings`.
void check_errors(const Machine& machine, const std::vector<AxisNotes>& axes,
                  const std::vector<ErrorNotes>& errors, Findings& machine_findings,
                  Findings& error_findings);

}  // namespace abbe
