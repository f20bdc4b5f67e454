#include "abbe/machine/csv_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "abbe/core/number.h"

namespace abbe {
namespace {

struct Cell {
  std::string_view text;
  Mark mark;
};

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r\"");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r\"") - begin + 1);
}

/// The cell of that index in a line, or nothing if the line is shorter.
std::optional<Cell> cell_of(std::string_view line, std::size_t line_number, char separator,
                            std::size_t index) {
  std::size_t begin = 0;
  for (std::size_t i = 0; i < index; ++i) {
    begin = line.find(separator, begin);
    if (begin == std::string_view::npos) return std::nullopt;
    ++begin;
  }
  const std::size_t end = std::min(line.find(separator, begin), line.size());
  const std::string_view text = trimmed(line.substr(begin, end - begin));
  const std::size_t column = text.empty() ? begin : static_cast<std::size_t>(text.data() - line.data());
  return Cell{text, Mark{line_number, column + 1, text.size()}};
}

bool is_skipped(std::string_view line) {
  const std::string_view text = trimmed(line);
  return text.empty() || text.front() == '#';
}

char separator_of(std::string_view header) {
  for (const char separator : {',', ';', '\t'}) {
    if (header.find(separator) != std::string_view::npos) return separator;
  }
  return ',';
}

std::size_t line_count(std::string_view text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
}

}  // namespace

struct CsvTables::Table {
  Table(std::string path, std::string bytes, Diagnostics& out)
      : text(std::move(bytes)), findings(std::move(path), text, out), lines(line_count(text)) {}

  std::string text;
  Findings findings;
  std::size_t lines;
  std::size_t header_line = 0;
  char separator = ',';
  std::vector<std::string> names;
};

CsvTables::CsvTables(const std::string& reader, const FileFetcher& fetch, Diagnostics& out)
    : folder_(std::filesystem::path(reader).parent_path().string()), fetch_(fetch), out_(out) {}

CsvTables::~CsvTables() = default;

CsvTables::Table* CsvTables::fetch_table(const std::string& path, Mark path_mark, Findings& findings) {
  const std::string full = (std::filesystem::path(folder_) / path).string();
  const auto known = tables_.find(full);
  if (known != tables_.end()) return known->second.get();
  auto& table = tables_[full];
  auto bytes = path.empty() || !fetch_ ? std::nullopt : fetch_(full);
  if (!bytes) {
    findings.error("E-CSV-FILE", path_mark, fmt::format("cannot read {}", in_quotes(full)),
                   "the path is relative to the folder of this file",
                   "correct the path, or put the file there");
    return nullptr;
  }
  if (bytes->starts_with("\xef\xbb\xbf")) bytes->replace(0, 3, "   ");  // keeps the columns
  files_.push_back(full);
  table = std::make_unique<Table>(full, std::move(*bytes), out_);
  for (std::size_t i = 1; i <= table->lines && table->header_line == 0; ++i) {
    const std::string_view line = table->findings.line(i);
    if (is_skipped(line)) continue;
    table->header_line = i;
    table->separator = separator_of(line);
    std::size_t begin = 0;
    while (begin <= line.size()) {
      const std::size_t end = std::min(line.find(table->separator, begin), line.size());
      table->names.emplace_back(trimmed(line.substr(begin, end - begin)));
      begin = end + 1;
    }
  }
  if (table->header_line == 0) {
    findings.error("E-CSV-FILE", path_mark, fmt::format("{} is empty", in_quotes(full)), "",
                   "write a header row, then one row per position");
    table.reset();
  }
  return table.get();
}

std::optional<CsvColumns> CsvTables::read(const std::string& path, Mark path_mark,
                                          const std::string& variable, const std::string& column,
                                          Mark column_mark, Findings& findings) {
  Table* table = fetch_table(path, path_mark, findings);
  if (table == nullptr) return std::nullopt;
  const auto& names = table->names;
  const auto index_of = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const std::size_t value_column = index_of(column);
  if (value_column == names.size()) {
    const std::vector<std::string> shown(names.begin(),
                                         names.begin() + std::min<std::ptrdiff_t>(40, std::ssize(names)));
    findings.error("E-CSV-COLUMN", column_mark,
                   fmt::format("{} has no column {}", in_quotes(table->findings.file()), in_quotes(column)),
                   "its columns are " + in_quotes(listed(shown, "and")),
                   suggestion(column, shown, "name one of them: column = \"...\""));
    return std::nullopt;
  }
  if (std::count(names.begin(), names.end(), column) > 1 ||
      std::count(names.begin(), names.end(), variable) > 1) {
    findings.error("E-CSV-COLUMN", column_mark,
                   fmt::format("{} has two columns of the same name", in_quotes(table->findings.file())),
                   "which of them is meant cannot be told", "give the columns different names");
    return std::nullopt;
  }
  const std::size_t named = index_of(variable);
  const std::size_t position_column = named == names.size() ? 0 : named;
  if (position_column == value_column) {
    findings.error("E-CSV-COLUMN", column_mark,
                   fmt::format("column {} holds the positions, not the error", in_quotes(column)),
                   fmt::format("positions are in the column {}, else in the first", in_quotes(variable)),
                   "name the column of the error: column = \"...\"");
    return std::nullopt;
  }

  CsvColumns out;
  const std::size_t errors_before = table->findings.error_count();
  for (std::size_t i = table->header_line + 1; i <= table->lines; ++i) {
    const std::string_view line = table->findings.line(i);
    if (is_skipped(line)) continue;
    const auto number = [&](std::size_t index) -> std::optional<double> {
      const auto cell = cell_of(line, i, table->separator, index);
      const auto value = cell ? read_number(cell->text) : std::nullopt;
      if (!value) {
        table->findings.error("E-CSV-CELL", cell ? cell->mark : Mark{i, line.size() + 1, 1},
                              !cell ? fmt::format("no cell for column {}", in_quotes(names[index]))
                              : cell->text.empty()
                                  ? fmt::format("the cell of column {} is blank", in_quotes(names[index]))
                                  : fmt::format("{} is not a number", in_quotes(cell->text)),
                              "a table must not have holes: they would be interpolated in silence",
                              "write the measured number, or remove the row");
      }
      return value;
    };
    const auto position = number(position_column);
    const auto value = number(value_column);
    if (!position || !value) continue;
    if (!out.positions.empty() && !(*position > out.positions.back())) {
      table->findings.error("E-POSITIONS", cell_of(line, i, table->separator, position_column)->mark,
                            fmt::format("position {} does not increase", to_shortest(*position)),
                            "positions are strictly increasing", "sort the rows and merge equal positions");
      break;
    }
    out.positions.push_back(*position);
    out.values.push_back(*value);
  }
  if (table->findings.error_count() != errors_before) return std::nullopt;
  if (out.positions.empty()) {
    findings.error("E-CSV-FILE", path_mark, fmt::format("{} has no rows", in_quotes(table->findings.file())),
                   "", "write one row per position below the header");
    return std::nullopt;
  }
  return out;
}

}  // namespace abbe
