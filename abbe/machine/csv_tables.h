#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/machine/findings.h"
#include "abbe/machine/read_machine.h"

namespace abbe {

/// Two columns of a CSV file.
struct CsvColumns {
  std::vector<double> positions;  ///< strictly increasing
  std::vector<double> values;
};

/// The CSV files that one machine or errors file names, each fetched and cut into cells once.
///
/// A header row, then rows of numbers. Cells are separated by commas; by semicolons or tabs if the
/// header has no comma. Blank lines and lines that begin with # are skipped. Cells of columns that are
/// not asked for may hold anything.
/// errors   every unsuitable cell is reported with its place in the CSV file
class CsvTables {
 public:
  /// `reader` is the file that names the tables: paths are relative to its folder.
  CsvTables(const std::string& reader, const FileFetcher& fetch, Diagnostics& out);
  ~CsvTables();

  /// Positions from the column `variable`, else the first; values from the column `column`.
  /// `path_mark` and `column_mark` are places in `findings` (the file that names the table).
  [[nodiscard]] std::optional<CsvColumns> read(const std::string& path, Mark path_mark,
                                               const std::string& variable, const std::string& column,
                                               Mark column_mark, Findings& findings);

  [[nodiscard]] const std::vector<std::string>& files() const { return files_; }

 private:
  struct Table;
  Table* fetch_table(const std::string& path, Mark path_mark, Findings& findings);

  std::string folder_;
  const FileFetcher& fetch_;
  Diagnostics& out_;
  std::map<std::string, std::unique_ptr<Table>> tables_;  ///< by path; null: cannot be used, reported
  std::vector<std::string> files_;
};

}  // namespace abbe
