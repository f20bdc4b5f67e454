#include "map_volume.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "abbe/core/number.h"

namespace abbe::app {
namespace {

/// What the options say about one axis.
struct AxisChoice {
  std::optional<std::array<double, 2>> range;    ///< mm or rad
  std::optional<std::vector<double>> positions;  ///< mm or rad
  std::optional<std::size_t> count;
  std::string_view option;  ///< that set range or positions
};

std::vector<std::string> pieces(std::string_view text, char separator) {
  std::vector<std::string> result;
  while (true) {
    const std::size_t end = text.find(separator);
    result.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) return result;
    text.remove_prefix(end + 1);
  }
}

/// Reads the volume options of one run; findings gather in `diagnostics`.
struct VolumeReader {
  const Machine& machine;
  Diagnostics diagnostics;
  std::vector<AxisChoice> axes;
  std::optional<std::size_t> count_of_all;

  explicit VolumeReader(const Machine& of) : machine(of), axes(static_cast<std::size_t>(of.axis_count())) {}

  void error(std::string_view option, std::string message, std::string fix = {}) {
    diagnostics.push_back(option_error(option, std::move(message), std::move(fix)));
  }

  [[nodiscard]] std::optional<std::size_t> axis_of(std::string_view option, const std::string& name) {
    const int axis = machine.find_axis(name);
    if (axis >= 0) return static_cast<std::size_t>(axis);
    std::string known;
    for (int i = 0; i < machine.axis_count(); ++i) known += (i == 0 ? "" : " ") + machine.axis(i).name;
    error(option, fmt::format("this machine has no moving axis '{}'", name), "its moving axes are " + known);
    return std::nullopt;
  }

  /// Numbers in the unit of the axis, converted; all of them or none.
  [[nodiscard]] std::optional<std::vector<double>> numbers(std::string_view option, std::size_t axis,
                                                           const std::vector<std::string>& texts) {
    std::vector<double> values;
    for (const std::string& text : texts) {
      const std::optional<double> value =
          option_number(option, machine.axis(static_cast<int>(axis)).name, text, diagnostics);
      if (!value) return std::nullopt;
      values.push_back(*value * machine.axis_unit(static_cast<int>(axis)));
    }
    return values;
  }

  [[nodiscard]] std::optional<std::size_t> read_count(std::string_view option, const std::string& text) {
    const std::optional<double> value = read_number(text);
    if (value && *value >= 1 && *value <= static_cast<double>(kMostMapPoints) && *value == std::floor(*value))
      return static_cast<std::size_t>(*value);
    error(option, fmt::format("'{}' is not a number of positions", text), "write a whole number, 1 or more");
    return std::nullopt;
  }

  /// False if another option has already said where the axis goes.
  [[nodiscard]] bool claim(std::string_view option, std::size_t axis) {
    AxisChoice& choice = axes[axis];
    if (choice.option.empty() || choice.option == option) {
      choice.option = option;
      return true;
    }
    error(option,
          fmt::format("'{}' is also given with {}", machine.axis(static_cast<int>(axis)).name, choice.option),
          "leave out one of the two");
    return false;
  }

  void read_ranges(const std::vector<std::string>& arguments) {
    for (const Assignment& given : split_assignments("--range", arguments, diagnostics)) {
      const std::optional<std::size_t> axis = axis_of("--range", given.name);
      if (!axis || !claim("--range", *axis)) continue;
      std::vector<std::string> parts = pieces(given.text, ':');
      if (parts.size() == 3) {
        axes[*axis].count = read_count("--range", parts[2]);
        if (!axes[*axis].count) continue;
        parts.pop_back();
      }
      if (parts.size() != 2) {
        error("--range", fmt::format("{}={} is not of the form {}=FROM:TO or {}=FROM:TO:COUNT", given.name,
                                     given.text, given.name, given.name));
        continue;
      }
      const auto ends = numbers("--range", *axis, parts);
      if (!ends) continue;
      if ((*ends)[0] < (*ends)[1]) {
        axes[*axis].range = {(*ends)[0], (*ends)[1]};
      } else {
        error("--range", fmt::format("{}={} does not increase", given.name, given.text),
              fmt::format("write the lower end first; one position is held with --at {}=..", given.name));
      }
    }
  }

  void read_positions(const std::vector<std::string>& arguments) {
    for (const Assignment& given : split_assignments("--positions", arguments, diagnostics)) {
      const std::optional<std::size_t> axis = axis_of("--positions", given.name);
      if (!axis || !claim("--positions", *axis)) continue;
      auto values = numbers("--positions", *axis, pieces(given.text, '/'));
      if (!values) continue;
      std::sort(values->begin(), values->end());
      if (std::adjacent_find(values->begin(), values->end()) != values->end()) {
        error("--positions", fmt::format("{}={} names a position twice", given.name, given.text));
      } else {
        axes[*axis].positions = std::move(values);
      }
    }
  }

  void read_held(const std::vector<std::string>& arguments) {
    for (const Assignment& given : split_assignments("--at", arguments, diagnostics)) {
      const std::optional<std::size_t> axis = axis_of("--at", given.name);
      if (axis && claim("--at", *axis)) axes[*axis].positions = numbers("--at", *axis, {given.text});
    }
  }

  void read_counts(const std::vector<std::string>& arguments) {
    std::vector<std::string> named;
    for (const std::string& argument : arguments) {
      if (argument.find('=') != std::string::npos) {
        named.push_back(argument);
      } else {
        count_of_all = read_count("--count", argument);
      }
    }
    for (const Assignment& given : split_assignments("--count", named, diagnostics)) {
      const std::optional<std::size_t> axis = axis_of("--count", given.name);
      if (!axis) continue;
      AxisChoice& choice = axes[*axis];
      if (choice.count || choice.positions) {
        error("--count",
              fmt::format("the positions of '{}' are also given with {}", given.name, choice.option),
              "leave out one of the two");
      } else {
        choice.count = read_count("--count", given.text);
      }
    }
  }

  /// The positions of every axis, once all options have been read without a mistake.
  [[nodiscard]] VolumeGrid grid() {
    std::size_t varying = 0;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      AxisChoice& choice = axes[i];
      const Body& axis = machine.axis(static_cast<int>(i));
      if (!choice.positions && !choice.range) choice.range = axis.range;
      if (choice.positions ? choice.positions->size() > 1 : choice.count.value_or(2) > 1) ++varying;
      if (choice.positions || choice.range) continue;
      const bool rotary = axis.type == AxisType::rotary;
      error("--range", fmt::format("the travel of '{}' is not known", axis.name),
            fmt::format("give --range {0}={1}, hold it with --at {0}=0, or write its range into the machine "
                        "file",
                        axis.name, rotary ? "FROM:TO (such as 0:360)" : "FROM:TO"));
    }
    VolumeGrid grid;
    if (has_errors(diagnostics)) return grid;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const AxisChoice& choice = axes[i];
      const std::size_t count = choice.count.value_or(count_of_all.value_or(default_count(varying)));
      auto positions =
          choice.positions ? choice.positions : spaced((*choice.range)[0], (*choice.range)[1], count);
      if (!positions) {
        error("--range",
              fmt::format("the range of '{}' is too large", machine.axis(static_cast<int>(i)).name));
        return grid;
      }
      grid.positions.push_back(std::move(*positions));
    }
    const std::size_t points = grid.size();
    if (points == 0 || points > kMostMapPoints) {
      std::string product;
      for (const auto& positions : grid.positions)
        product += fmt::format("{}{}", product.empty() ? "" : " x ", positions.size());
      error("--count", fmt::format("{} points are more than {}", product, kMostMapPoints),
            "fewer positions per axis, or hold axes with --at");
    }
    return grid;
  }
};

}  // namespace

void add_volume_options(Command& verb, VolumeArguments& arguments) {
  const auto list = [&](const char* name, std::vector<std::string>& to, const char* what, const char* type) {
    verb.add_option(name, to, what)->type_name(type)->allow_extra_args(false);
  };
  list("--range", arguments.range, "part of the travel, and how many positions: X=-100:400, C=0:360:13",
       "AXIS=FROM:TO[:COUNT],..");
  list("--positions", arguments.positions, "chosen positions: X=0/50/200", "AXIS=P/P/..,..");
  list("--at", arguments.at, "axes that are held: A=0,C=90", "AXIS=VALUE,..");
  list("--count", arguments.count, "positions per axis, of all or of one: 21 or X=41,Z=11", "N|AXIS=N,..");
  list("--datum-at", arguments.datum,
       "where the workpiece is touched off (axes not named: 0, or the end nearest to 0)", "AXIS=VALUE,..");
  verb.add_option("--threads", arguments.threads, "processors to use (all); the result does not depend on it")
      ->check(whole_in(1, 4096))
      ->type_name("N");
}

std::optional<VolumeQuestion> read_volume(const VolumeArguments& arguments, const Setting& setting,
                                          Session& session) {
  VolumeReader reader(setting.machine);
  reader.read_ranges(arguments.range);
  reader.read_positions(arguments.positions);
  reader.read_held(arguments.at);
  reader.read_counts(arguments.count);
  VolumeQuestion question;
  question.grid = reader.grid();
  if (!has_errors(reader.diagnostics)) question.datum = default_datum(question.grid);
  for (const Assignment& given : split_assignments("--datum-at", arguments.datum, reader.diagnostics)) {
    const std::optional<std::size_t> axis = reader.axis_of("--datum-at", given.name);
    if (!axis) continue;
    const auto value = reader.numbers("--datum-at", *axis, {given.text});
    if (value) question.datum[*axis] = value->front();
  }
  session.report(reader.diagnostics);
  if (has_errors(reader.diagnostics)) return std::nullopt;
  question.circumstances.approach = setting.approach;
  question.circumstances.tool = tool_of(setting.machine);
  question.circumstances.threads = arguments.threads;
  return question;
}

std::vector<std::string> outside_travel(const Machine& machine, const VolumeGrid& grid) {
  std::array<double, kMaxAxes> lowest{}, highest{};
  for (std::size_t i = 0; i < grid.positions.size(); ++i) {
    const auto [lo, hi] = std::minmax_element(grid.positions[i].begin(), grid.positions[i].end());
    lowest[i] = *lo;
    highest[i] = *hi;
  }
  std::vector<std::string> names = outside_travel(machine, lowest);
  for (std::string& name : outside_travel(machine, highest))
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(std::move(name));
  return names;
}

}  // namespace abbe::app
