#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "abbe/core/diagnostic.h"
#include "abbe/machine/machine.h"

namespace abbe {

/// Fetches the bytes of a file named in a machine file (CSV tables), or nullopt if it cannot be read.
using FileFetcher = std::function<std::optional<std::string>(const std::string& path)>;

struct MachineText {
  std::string file;  ///< name for diagnostics; CSV paths are relative to its folder
  std::string text;
};

/// Reads a machine file (docs/machine-file.md), optionally with the errors of a second file in place
/// of its [errors] table. All mistakes are reported, each with its place and a suggestion.
/// Total: any bytes give a value or diagnostics.
[[nodiscard]] Parsed<Machine> read_machine(const MachineText& machine,
                                           const std::optional<MachineText>& errors,
                                           const FileFetcher& fetch);

/// The same from disk. A file that cannot be read is a diagnostic with code E-FILE.
[[nodiscard]] Parsed<Machine> read_machine_file(const std::string& machine_path,
                                                const std::optional<std::string>& errors_path = std::nullopt);

}  // namespace abbe
