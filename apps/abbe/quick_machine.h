#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "command_line.h"

namespace abbe::app {

/// A machine of three axes from the command line, for users without a machine file: as typed.
struct QuickMachine {
  std::vector<std::string> skew, scale, pitch;
  [[nodiscard]] bool given() const { return !skew.empty() || !scale.empty() || !pitch.empty(); }
};

/// --skew, --scale, --pitch.
void add_quick_machine_options(Command& verb, QuickMachine& quick);

/// The machine file that says the same: chain "w b X Y Z t", EC0Y = XY, EB0Z = -XZ, EA0Z = YZ (positive: the
/// angle between the positive directions is obtuse), EXX = (scale - 1) X + pitch(X). nullopt after reporting
/// mistakes.
[[nodiscard]] std::optional<std::string> machine_text_of(const QuickMachine& quick, Diagnostics& findings);

}  // namespace abbe::app
