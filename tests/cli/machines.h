#pragma once

#include <string>

namespace abbe::cli {

/// Table X, column Y, head Z, with errors whose effect is worked out in the head: EXX 0.1 um/mm as seen
/// at the tool, EYY 5 um, TZZ 2 um per degree of T1 above 20. Ends within [errors].
inline constexpr const char* kThreeAxes = R"(format = 1
[machine]
name = "three axes"
chain = "w X b Y Z t"
[axis.X]
range = [-400, 400]
errors_seen = "tool"
[axis.Y]
range = [-250, 250]
[axis.Z]
range = [-300, 100]
[errors]
EXX = { poly = [0, 0.1] }
EYY = 5
TZZ = { poly = [0, 2], of = "T1", reference = 20 }
)";

/// Rotary table C on the table X, column Y, head Z, tilting head A whose axis is 200 mm above the tip.
inline constexpr const char* kFiveAxes = R"(format = 1
[machine]
name = "five axes"
chain = "w C X b Y Z A t"
[axis.C]
direction = [0, 0, -1]
[axis.X]
range = [-400, 400]
errors_seen = "tool"
[axis.A]
origin = [0, 0, 200]
range = [-100, 100]
[tool]
length = 200
[errors]
EXX = { poly = [0, 0.1] }
EY0A = 10
)";

/// A machine text with other errors.
inline std::string with_errors(std::string machine, const std::string& errors) {
  constexpr const char* kErrors = "[errors]\n";
  machine.erase(machine.find(kErrors));
  return machine + kErrors + errors;
}

}  // namespace abbe::cli
