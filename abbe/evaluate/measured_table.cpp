#include "abbe/evaluate/measured_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/evaluate/text_findings.h"

namespace abbe {
namespace {

constexpr double kLargest = 1e12;  // no measurement: its square and sums must stay finite
constexpr double kMinute = 60, kHour = 3600;
constexpr std::array<MeasuredUnit, 16> kUnits = {{{"mm", Quantity::length, mm},
                                                  {"um", Quantity::length, um},
                                                  {"\xC2\xB5m", Quantity::length, um},
                                                  {"\xCE\xBCm", Quantity::length, um},
                                                  {"nm", Quantity::length, nm},
                                                  {"m", Quantity::length, metre},
                                                  {"in", Quantity::length, inch},
                                                  {"deg", Quantity::angle, deg},
                                                  {"rad", Quantity::angle, rad},
                                                  {"mrad", Quantity::angle, mrad},
                                                  {"urad", Quantity::angle, urad},
                                                  {"arcsec", Quantity::angle, arcsec},
                                                  {"s", Quantity::time, 1},
                                                  {"min", Quantity::time, kMinute},
                                                  {"h", Quantity::time, kHour},
                                                  {"degC", Quantity::temperature, 1}}};

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
constexpr std::string_view kDirection = "direction";

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r\"");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r\"") - begin + 1);
}

std::vector<std::string_view> cells_of(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    cells.push_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

char separator_of(std::string_view header) {
  for (const char separator : {',', ';', '\t'})
    if (header.find(separator) != std::string_view::npos) return separator;
  return ',';
}

std::string shown(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  return fmt::format("'{}'", word.substr(0, kLongest));
}

/// "name [unit]" or "name".
std::optional<MeasuredColumn> read_heading(std::string_view cell, std::size_t line, TextFindings& findings) {
  MeasuredColumn column;
  const std::size_t open = cell.find('[');
  column.name = std::string(trimmed(cell.substr(0, open)));
  if (column.name.empty()) {
    findings.error("E-MEASURED-HEADER", line, "a column without a name", "what it holds cannot be told",
                   "name every column, as in: target [mm]");
    return std::nullopt;
  }
  if (open == std::string_view::npos) return column;
  const std::size_t close = cell.find(']', open);
  const std::string_view name =
      trimmed(cell.substr(open + 1, close == std::string_view::npos ? close : close - open - 1));
  const MeasuredUnit* unit = find_measured_unit(name);
  if (unit == nullptr || close == std::string_view::npos) {
    findings.error("E-MEASURED-HEADER", line, fmt::format("{} is not a unit", shown(name)),
                   "a wrong unit spoils every number of the column",
                   fmt::format("write one of [{}]", measured_unit_names()));
    return std::nullopt;
  }
  column.quantity = unit->quantity;
  column.unit = unit->factor;
  return column;
}

bool read_header(std::string_view text, char separator, std::size_t line, MeasuredTable& table,
                 TextFindings& findings) {
  for (const std::string_view cell : cells_of(text, separator)) {
    std::optional<MeasuredColumn> column = read_heading(cell, line, findings);
    if (!column) continue;
    if (table.find(column->name) != nullptr)
      findings.error("E-MEASURED-HEADER", line, fmt::format("two columns {}", shown(column->name)),
                     "which of them is meant cannot be told", "give them different names");
    table.columns.push_back(std::move(*column));
  }
  return !findings.failed();
}

std::optional<double> read_cell(std::string_view cell, const MeasuredColumn& column) {
  if (column.name == kDirection) {
    if (cell == "+" || cell == "+1" || cell == "1") return 1;
    if (cell == "-" || cell == "-1") return -1;
    return std::nullopt;
  }
  const std::optional<double> number = read_number(cell);
  if (!number || !(std::abs(*number * column.unit) < kLargest)) return std::nullopt;
  return *number * column.unit;
}

void read_row(std::string_view text, char separator, std::size_t line, MeasuredTable& table,
              TextFindings& findings) {
  const std::vector<std::string_view> cells = cells_of(text, separator);
  if (cells.size() != table.columns.size()) {
    findings.error("E-MEASURED-CELL", line,
                   fmt::format("{} cells under {} columns", cells.size(), table.columns.size()),
                   "a number could land in the wrong column", "write one cell for every column");
    return;
  }
  std::vector<double> row;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const MeasuredColumn& column = table.columns[i];
    if (const std::optional<double> value = read_cell(cells[i], column)) {
      row.push_back(*value);
      continue;
    }
    findings.error(
        "E-MEASURED-CELL", line,
        cells[i].empty() ? fmt::format("the cell of {} is blank", shown(column.name))
                         : fmt::format("{} in column {} is not a {}", shown(cells[i]), shown(column.name),
                                       column.name == kDirection ? "direction" : "finite number"),
        "nothing is filled in for a missing measurement",
        column.name == kDirection ? "write + or -" : "write the measured number, or remove the row");
  }
  if (row.size() != cells.size()) return;
  for (std::size_t i = 0; i < row.size(); ++i) table.columns[i].values.push_back(row[i]);
  table.lines.push_back(line);
}

}  // namespace

const MeasuredUnit* find_measured_unit(std::string_view name) {
  const auto found =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const MeasuredUnit& unit) { return unit.name == name; });
  return found == kUnits.end() ? nullptr : &*found;
}

std::string measured_unit_names() {
  std::string names;
  for (const MeasuredUnit& unit : kUnits)
    if (static_cast<unsigned char>(unit.name.front()) < 0x80)
      names += (names.empty() ? "" : " ") + std::string(unit.name);
  return names;
}

const MeasuredColumn* MeasuredTable::find(std::string_view name) const {
  const auto found = std::find_if(columns.begin(), columns.end(),
                                  [&](const MeasuredColumn& column) { return column.name == name; });
  return found == columns.end() ? nullptr : &*found;
}

Parsed<MeasuredTable> read_measured_table(const std::string& file, std::string_view text) {
  Parsed<MeasuredTable> out;
  TextFindings findings(file);
  MeasuredTable table;
  table.file = file;
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  char separator = ',';
  for (std::size_t begin = 0, number = 1; begin < text.size() && !findings.full(); ++number) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    begin = end + 1;
    const std::string_view content = trimmed(line);
    if (content.empty() || content.front() == '#') continue;
    if (table.columns.empty()) {
      separator = separator_of(line);
      if (!read_header(line, separator, number, table, findings)) break;
    } else {
      read_row(line, separator, number, table, findings);
    }
  }
  if (!findings.failed() && table.rows() == 0)
    findings.error("E-MEASURED-HEADER", 0,
                   table.columns.empty() ? "the file is empty" : "there are no rows below the header", "",
                   "write a header row, then one row per reading");
  if (!findings.failed()) out.value = std::move(table);
  out.diagnostics = findings.take();
  return out;
}

}  // namespace abbe
