#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"

namespace abbe::app {

/// Streams a CSV file of numbers row by row in constant memory: a header row of column names, then
/// rows with as many cells. Cells are separated by commas, may be quoted, end-of-line may be LF or
/// CR LF, a byte order mark is skipped, empty lines at the end are allowed.
///
/// errors   the first mistake stops the reading: failure() says what and where; next() and number()
///          then give nothing. A blank cell, text that is not a finite number, a row with too few
///          or too many cells and an empty line between rows are mistakes.
class CsvReader {
 public:
  /// "-" is standard input; a pipe is read whole first, like it. A file without a header is a failure() of
  /// the reader.
  [[nodiscard]] static FileResult<CsvReader> open(const std::string& path);

  [[nodiscard]] const std::vector<std::string>& header() const { return header_; }

  /// Goes to the next row; false at the end and after a mistake.
  [[nodiscard]] bool next();
  /// The cell of this row as a number; nullopt reports the mistake.
  [[nodiscard]] std::optional<double> number(std::size_t column);
  /// The cell of this row as text without blanks around it.
  [[nodiscard]] std::string_view text(std::size_t column) const;

  [[nodiscard]] std::size_t line() const { return line_; }
  [[nodiscard]] std::uint64_t bytes_read() const { return lines_.bytes_read(); }
  [[nodiscard]] std::uint64_t bytes_total() const { return lines_.identity().size; }

  [[nodiscard]] bool failed() const { return failure_.has_value(); }
  [[nodiscard]] const std::optional<Diagnostic>& failure() const { return failure_; }
  /// The reading of the file broke off (I/O), unlike a mistake in the file.
  [[nodiscard]] bool broken() const { return broken_; }

  /// A finding about a cell of this row, or about the row.
  [[nodiscard]] Diagnostic error_at(std::size_t column, std::string code, std::string message) const;
  [[nodiscard]] Diagnostic error_at_line(std::string code, std::string message) const;
  /// Stops the reading because of a cell.
  void fail_at(std::size_t column, std::string code, std::string message, std::string fix = {});

 private:
  CsvReader(std::string name, std::optional<SpooledInput> spooled, LineReader lines)
      : name_(std::move(name)), spooled_(std::move(spooled)), lines_(std::move(lines)) {}
  struct Cell {
    std::size_t start, length;
  };
  [[nodiscard]] bool read_line();
  [[nodiscard]] bool split();

  std::string name_;
  std::optional<SpooledInput> spooled_;  ///< keeps the copy of standard input while it is read
  LineReader lines_;
  std::vector<std::string> header_;
  std::string row_;
  std::vector<Cell> cells_;
  std::size_t line_ = 0;
  std::optional<Diagnostic> failure_;
  bool broken_ = false;
};

}  // namespace abbe::app
