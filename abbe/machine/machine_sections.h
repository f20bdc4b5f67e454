#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/machine/machine.h"
#include "abbe/machine/toml_document.h"

namespace abbe {

// The tables of a machine file, one function each. `root` is the whole file. After a mistake, which
// is reported, the default of the key is used, so that the rest of the file can be checked too.

/// `format = 1`.
void check_format(const TomlNode& root, Findings& findings);

/// The table of that name at the top of the file, or nullptr (also if it is not a table: reported).
[[nodiscard]] const TomlNode* find_table(const TomlNode& root, std::string_view name, Findings& findings);

[[nodiscard]] FileUnits read_units(const TomlNode& root, Findings& findings);

/// [tool]; the default of its origin is the origin of the last tool-branch body, else the bed's.
[[nodiscard]] ToolMount read_tool(const TomlNode& root, const FileUnits& units,
                                  const std::vector<Body>& bodies, Findings& findings);

[[nodiscard]] Vec3 read_workpiece_origin(const TomlNode& root, const FileUnits& units, Findings& findings);

[[nodiscard]] Calibration read_calibration(const TomlNode& root, Findings& findings);

}  // namespace abbe
