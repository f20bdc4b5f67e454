#pragma once

#include <map>
#include <optional>
#include <string>

#include "abbe/machine/read_machine.h"

namespace abbe::test {

/// A five-axis machine with a spindle; `more` follows its last table.
inline std::string five_axis(const std::string& more) {
  return "format = 1\n"
         "[machine]\n"
         "chain = \"w C X b Y Z A S t\"\n"
         "[axis.C]\n"
         "direction = [0, 0, 1]\n"
         "errors_seen = \"body\"\n"
         "[axis.X]\n"
         "errors_seen = \"tool\"\n" +
         more;
}

/// Reads texts that may name CSV files of `files`.
inline Parsed<Machine> read(const std::string& text, const std::map<std::string, std::string>& files = {},
                            const std::optional<std::string>& errors = std::nullopt) {
  const auto fetch = [&files](const std::string& path) -> std::optional<std::string> {
    const auto at = files.find(path);
    if (at == files.end()) return std::nullopt;
    return at->second;
  };
  std::optional<MachineText> second;
  if (errors) second = MachineText{"folder/errors.toml", *errors};
  return read_machine({"folder/machine.toml", text}, second, fetch);
}

/// All diagnostics as text, for messages of failed tests.
inline std::string all_of(const Diagnostics& diagnostics) {
  std::string out;
  for (const Diagnostic& diagnostic : diagnostics) out += to_text(diagnostic);
  return out;
}

}  // namespace abbe::test
