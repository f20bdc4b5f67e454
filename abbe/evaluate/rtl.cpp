#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/evaluate/run_table.h"
#include "abbe/evaluate/text_findings.h"

namespace abbe {
namespace {

struct RtlRow {
  int run = 0, target = 0;
  double deviation = 0;
  std::size_t line = 0;
};

/// What an .rtl file holds, in its own numbers.
struct RtlFile {
  std::string owner;
  std::optional<double> target_count;
  std::vector<double> targets;
  std::vector<RtlRow> rows;
};

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t at = text.find_first_not_of(" \t\r"); at != std::string_view::npos;
       at = text.find_first_not_of(" \t\r", at)) {
    const std::size_t end = std::min(text.find_first_of(" \t\r", at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end;
  }
  return words;
}

/// Follows the lines: a section ends in "::", a key in ":", the lists go on until the next of either.
class RtlReader {
 public:
  RtlReader(std::string_view text, TextFindings& findings) : findings_(findings) {
    for (std::size_t begin = 0, number = 1; begin < text.size() && !findings.full(); ++number) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      take(trimmed(text.substr(begin, end - begin)), number);
      begin = end + 1;
    }
  }

  RtlFile file;

 private:
  enum class List { none, targets, deviations };

  void take(std::string_view line, std::size_t number) {
    if (line.empty()) return;
    if (line.ends_with("::")) {
      section_ = line.substr(0, line.size() - 2);
      list_ = List::none;
      return;
    }
    const std::size_t colon = line.find(':');
    if (colon != std::string_view::npos) {
      take_key(trimmed(line.substr(0, colon)), trimmed(line.substr(colon + 1)), number);
      return;
    }
    take_numbers(line, number);
  }

  void take_key(std::string_view key, std::string_view value, std::size_t number) {
    list_ = List::none;
    if (key == "Owner") file.owner = std::string(value);
    if (section_ == "TARGET DATA" && key == "Target-count") file.target_count = read_number(value);
    if (section_ == "TARGET DATA" && key == "Targets") list_ = List::targets;
    if (section_ == "DEVIATIONS" && key == "Run Target Data") list_ = List::deviations;
    if (list_ != List::none && !value.empty()) take_numbers(value, number);
  }

  void take_numbers(std::string_view line, std::size_t number) {
    if (list_ == List::none) return;
    std::vector<double> numbers;
    for (const std::string_view word : words_of(line)) {
      if (const std::optional<double> value = read_number(word)) {
        numbers.push_back(*value);
        continue;
      }
      complain(number, fmt::format("'{}' is not a number", word.substr(0, 40)));
      return;
    }
    if (list_ == List::targets) {
      for (const double target : numbers)
        if (!(std::abs(target) < 1e12)) return complain(number, "a target beyond every machine");
      file.targets.insert(file.targets.end(), numbers.begin(), numbers.end());
    } else {
      take_row(numbers, number);
    }
  }

  void take_row(const std::vector<double>& numbers, std::size_t number) {
    constexpr double kMost = 1e6;
    const auto counts = [](double value) {
      return value >= 1 && value <= kMost && value == std::floor(value);
    };
    if (numbers.size() != 3 || !(std::abs(numbers[2]) < kMost * kMost) || !counts(numbers[0]) ||
        !counts(numbers[1])) {
      complain(number, "a row of deviations is not: run, number of the target, deviation");
      return;
    }
    file.rows.push_back({static_cast<int>(numbers[0]), static_cast<int>(numbers[1]), numbers[2], number});
  }

  void complain(std::size_t number, std::string what) {
    findings_.error("E-RTL-FORM", number, std::move(what),
                    "the form of .rtl files is known from programs of third parties only",
                    "export the runs as CSV (docs/measurement-files.md)");
  }

  TextFindings& findings_;
  std::string section_;
  List list_ = List::none;
};

/// Directions of the runs: that in which the positions of their targets proceed, for a list of targets may
/// itself fall; nothing for runs that do not proceed.
std::map<int, int> directions_of(const RtlFile& rtl) {
  std::map<int, double> last;
  std::map<int, int> direction;
  for (const RtlRow& row : rtl.rows) {
    const double position = rtl.targets[static_cast<std::size_t>(row.target - 1)];
    const auto known = last.find(row.run);
    if (known != last.end()) {
      const int step = position > known->second ? 1 : -1;
      const auto before = direction.find(row.run);
      direction[row.run] = before == direction.end() || before->second == step ? step : 0;
    }
    last[row.run] = position;
  }
  return direction;
}

bool complete(const RtlFile& rtl, TextFindings& findings) {
  const auto complain = [&](std::string what) {
    findings.error("E-RTL-FORM", 0, std::move(what), "without it the deviations have no places",
                   "export the runs as CSV (docs/measurement-files.md)");
  };
  if (rtl.targets.empty()) complain("no targets below 'TARGET DATA::', 'Targets :'");
  if (rtl.rows.empty()) complain("no rows below 'DEVIATIONS::', 'Run Target Data:'");
  if (rtl.target_count && *rtl.target_count != static_cast<double>(rtl.targets.size()))
    complain(
        fmt::format("Target-count is {:g}, but there are {} targets", *rtl.target_count, rtl.targets.size()));
  const auto beyond = std::find_if(rtl.rows.begin(), rtl.rows.end(), [&](const RtlRow& row) {
    return static_cast<std::size_t>(row.target) > rtl.targets.size();
  });
  if (beyond != rtl.rows.end())
    complain(fmt::format("a deviation at target {} of {}", beyond->target, rtl.targets.size()));
  return !findings.failed();
}

}  // namespace

Parsed<RunTable> read_rtl(const std::string& file, std::string_view text, const MeasuredUnit* unit) {
  TextFindings findings(file);
  const RtlFile rtl = RtlReader(text, findings).file;
  if (findings.failed() || !complete(rtl, findings)) return {std::nullopt, findings.take()};
  if (unit == nullptr && rtl.owner != "Linear") {
    findings.error("E-RTL-UNIT", 0, fmt::format("the owner is '{}', not 'Linear'", rtl.owner.substr(0, 40)),
                   "the unit of such deviations is not known", "state it: unit = \"arcsec\" (or um, urad)");
    return {std::nullopt, findings.take()};
  }
  const MeasuredUnit* used = unit != nullptr ? unit : find_measured_unit("um");
  const bool rotary = rtl.owner.find("otary") != std::string::npos;
  const std::map<int, int> directions = directions_of(rtl);
  std::vector<RunReading> readings;
  for (const RtlRow& row : rtl.rows) {
    const auto direction = directions.find(row.run);
    if (direction == directions.end() || direction->second == 0) {
      findings.error("E-RTL-FORM", row.line,
                     fmt::format("run {} does not proceed from target to target", row.run),
                     "its direction of approach cannot be told", "export the runs as CSV");
      return {std::nullopt, findings.take()};
    }
    const double target = rtl.targets[static_cast<std::size_t>(row.target - 1)] * (rotary ? deg : mm);
    readings.push_back({target, row.deviation * used->factor, row.run, direction->second > 0, row.line});
  }
  findings.warning("W-RTL-FORM", 0, "read by what third parties know about .rtl files",
                   "their maker publishes no description",
                   "compare a few deviations with the instrument's own printout");
  Parsed<RunTable> out =
      sort_runs(file, readings, rotary ? Quantity::angle : Quantity::length, used->quantity);
  Diagnostics all = findings.take();
  all.insert(all.end(), out.diagnostics.begin(), out.diagnostics.end());
  out.diagnostics = std::move(all);
  return out;
}

}  // namespace abbe
