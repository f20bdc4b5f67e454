#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "abbe/core/number.h"
#include "abbe/machine/control_setup.h"
#include "abbe/machine/findings.h"

// The parameter file of LinuxCNC: a number and a value per line, numbers rising.
//
//   5161..5186  G28 and G30 positions     5210..5219  G92: active, X Y Z A B C U V W
//   5220        coordinate system 1..9    5221 + 20 k  of G54 + k: X Y Z A B C U V W, rotation (deg)

namespace abbe {
namespace {

constexpr int kG92Active = 5210;
constexpr int kG92Last = 5219;
constexpr int kActiveSystem = 5220;
constexpr int kFirstOffset = 5221;
constexpr int kSystemStride = 20;
constexpr int kSystems = 9;
constexpr int kRotation = 9;  // after nine axes

constexpr std::string_view kAxisLetters = "XYZABCUVW";

struct Parameter {
  int number = 0;
  double value = 0;
  Mark mark;  // of the value
};

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  std::size_t at = 0;
  while ((at = line.find_first_not_of(" \t\r", at)) != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
    cells.push_back(line.substr(at, end - at));
    at = end;
  }
  return cells;
}

std::optional<Parameter> read_line(std::size_t number, std::string_view line, Findings& findings) {
  const auto cells = cells_of(line);
  if (cells.empty() || cells[0].front() == '#' || cells[0].front() == ';') return std::nullopt;
  const auto id = read_number(cells[0]);
  const auto value = cells.size() == 2 ? read_number(cells[1]) : std::nullopt;
  constexpr double kMostParameters = 5602;
  if (!id || !value || *id < 1 || *id > kMostParameters || *id != std::floor(*id)) {
    findings.error("E-PARAM-LINE", Mark{number, 1, line.size()}, "this is not a parameter",
                   "a line holds a parameter number and its value", "write it like: 5221 100.0");
    return std::nullopt;
  }
  const auto column = static_cast<std::size_t>(cells[1].data() - line.data()) + 1;
  return Parameter{static_cast<int>(*id), *value, {number, column, cells[1].size()}};
}

/// One parameter into the setup; those without influence on positions are passed over.
class Collector {
 public:
  explicit Collector(Findings& findings) : findings_(findings) {}

  void take(const Parameter& parameter) {
    if (parameter.number == kG92Active) {
      g92_active_ = parameter.value != 0;
    } else if (parameter.number > kG92Active && parameter.number <= kG92Last) {
      take_g92(parameter);
    } else if (parameter.number == kActiveSystem) {
      take_active_system(parameter);
    } else if (parameter.number >= kFirstOffset &&
               parameter.number < kFirstOffset + kSystems * kSystemStride) {
      take_offset(parameter);
    }
  }

  ControlSetup setup;

 private:
  void take_g92(const Parameter& parameter) {
    if (!g92_active_ || parameter.value == 0) return;
    findings_.error("E-PARAM-G92", parameter.mark,
                    fmt::format("a G92 offset in {} is active",
                                kAxisLetters[static_cast<std::size_t>(parameter.number - kG92Active - 1)]),
                    "the control applies it before the program begins, and it is not followed here",
                    "cancel it with G92.1 on the control and read the file again");
  }

  void take_active_system(const Parameter& parameter) {
    if (parameter.value == 1) return;
    findings_.warning(
        "W-PARAM-SYSTEM", parameter.mark,
        fmt::format("coordinate system {} is active on the control", to_shortest(parameter.value)),
        "a program that names no system is read with G54, the first one",
        "name the work offset in the program");
  }

  void take_offset(const Parameter& parameter) {
    const int index = (parameter.number - kFirstOffset) / kSystemStride;
    const int item = (parameter.number - kFirstOffset) % kSystemStride;
    if (item > kRotation) return;
    auto& offset = setup.work_offsets[static_cast<std::size_t>(index)];
    if (!offset) offset = WorkOffset{};
    if (item < 3) {
      offset->origin[static_cast<std::size_t>(item)] = parameter.value;
    } else if (item == kRotation) {
      offset->rotation = parameter.value * deg;
    } else if (parameter.value != 0) {
      findings_.error("E-PARAM-OFFSET", parameter.mark,
                      fmt::format("a work offset in {}", kAxisLetters[static_cast<std::size_t>(item)]),
                      "offsets of axes other than X Y Z are not followed here: positions would be wrong",
                      "set it to 0 and put the offset into the program");
    }
  }

  Findings& findings_;
  bool g92_active_ = false;
};

}  // namespace

Parsed<ControlSetup> read_parameter_file(const std::string& file, const std::string& text) {
  Parsed<ControlSetup> out;
  Findings findings(file, text, out.diagnostics);
  Collector collector(findings);
  int last = 0;
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
  for (std::size_t i = 1; i <= lines && !findings.full(); ++i) {
    const auto parameter = read_line(i, findings.line(i), findings);
    if (!parameter) continue;
    if (parameter->number <= last) {
      findings.error("E-PARAM-LINE", Mark{i, 1, findings.line(i).size()},
                     fmt::format("parameter {} after {}", parameter->number, last),
                     "numbers rise; the control refuses the file otherwise",
                     "sort the lines, keep each number once");
      continue;
    }
    last = parameter->number;
    collector.take(*parameter);
  }
  if (!has_errors(out.diagnostics)) out.value = std::move(collector.setup);
  return out;
}

}  // namespace abbe
