#pragma once

// For tests of runs of plain lines: a machine with two rotary axes, and programs that turn them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <random>
#include <string>

#include "abbe/machine/read_machine.h"

namespace abbe::testing {

/// Table-table, errors that bend (cubic tables), straight pieces (linear ones) and constants.
inline Machine five_axes(const std::string& more_errors = {}) {
  const std::string text = std::string(R"(format = 1
[machine]
name = "five axes"
chain = "w C A Y b X Z t"
[axis.X]
range = [-450, 450]
[axis.Z]
range = [-300, 300]
[axis.A]
range = [-100, 100]
direction = [-1, 0, 0]
origin = [0, 0, -50]
errors_seen = "tool"
[axis.C]
direction = [0, 0, -1]
origin = [0, 30, -80]
errors_seen = "tool"
[axis.Y]
range = [-350, 350]
errors_seen = "tool"
[control]
mode = "axis"
[tool]
origin = [0, 0, 300]
length = 150
[workpiece]
origin = [0, 30, -80]
[errors]
EXX = { interpolation = "cubic", table = [[-500, 4], [-200, -9], [0, 0], [150, 8], [500, -3]] }
EBX = { table = [[-500, 10], [-20, -4], [120, 6], [500, 2]] }
EYY = { sine = [6, 0.021, 0.4] }
ECY = { poly = [0, 0.03] }
EZZ = { table = [[-300, -4], [0, 3], [300, 7]], interpolation = "cubic" }
EAZ = { poly = [3, 0.02] }
EXC = { table = [[-360, 3], [-90, -8], [45, 9], [360, -2]], interpolation = "cubic" }
EAC = { table = [[-360, 12], [0, -7], [360, 12]], interpolation = "cubic" }
EYA = { table = [[-100, 3], [20, -8], [100, 9]], interpolation = "cubic" }
EBA = { table = [[-100, 12], [30, -7], [100, 12]], interpolation = "cubic" }
EC0X = 20
EA0C = 14
EB0C = -8
EY0A = 11
EZ0A = 6
EC0A = -9
)") + more_errors;
  const Parsed<Machine> parsed = read_machine(
      {"five.toml", text}, std::nullopt, [](const std::string&) { return std::optional<std::string>(); });
  EXPECT_TRUE(parsed.value.has_value());
  return *parsed.value;
}

/// Programs of plain lines and all that comes between them.
class RandomProgram {
 public:
  explicit RandomProgram(unsigned seed) : random_(seed) {}

  std::string text(int lines) {
    std::string out = "G21 G90 G17 G54 G94\nG0 X0 Y10 Z20 A30 C0\nG1 X1 Y10 Z20 A30.5 C0.5 F2000\n";
    for (int i = 0; i < lines; ++i) out += below(12) == 0 ? other() : plain();
    return out + "M2\n";
  }

 private:
  double uniform(double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(random_()) / 4294967296.0);
  }
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*f", below(6) == 0 ? 1 + below(6) : 4, value);
    return text;
  }
  std::string plain() {
    const double step = below(20) == 0 ? 30 : 0.8;
    for (int k = 0; k < 3; ++k) at_[k] = std::clamp(at_[k] + uniform(-step, step), -150.0, 150.0);
    at_[3] = std::clamp(at_[3] + uniform(-0.4, 0.4) * (step > 1 ? 8 : 1), -80.0, 80.0);
    at_[4] += uniform(-0.4, 0.4);
    std::string line;
    const bool spaced = below(3) != 0;
    for (int k = 0; k < 5; ++k) {
      if (below(9) == 0) continue;
      if (spaced && !line.empty()) line += ' ';
      line += "XYZAC"[k] + number(at_[k]);
    }
    if (line.empty()) line = "X" + number(at_[0]);
    if (below(9) == 0) line += (spaced ? " F" : "F") + number(500 + below(2000));
    return line + (below(30) == 0 ? "\r\n" : "\n");
  }
  std::string other() {
    switch (below(9)) {
      case 0:
        return "(a comment)\n";
      case 1:
        return "G1 " + plain();
      case 2:
        return "N" + std::to_string(++count_) + " " + plain();
      case 3:
        return "G0 " + plain() + "G1\n";
      case 4:
        return "G91 A0.5 C-0.25\nG90\n";
      case 5:
        return "M8\n";
      case 6:
        return "x1.5 a 20.5 C+3\n";
      case 7:
        return "G93 X1 A31 C2 F20\nG94 F1000\n";
      default:
        return "A" + number(at_[3] + 0.3) + "\n";
    }
  }

  std::mt19937 random_;
  double at_[5] = {0, 10, 20, 30, 0};
  int count_ = 0;
};

}  // namespace abbe::testing
