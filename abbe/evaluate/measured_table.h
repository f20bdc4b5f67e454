#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/diagnostic.h"

namespace abbe {

/// What a column of measured numbers is a quantity of.
enum class Quantity { number, length, angle, time, temperature };

/// A unit as files write it: internal value (mm, rad, s, degC) = factor * number.
struct MeasuredUnit {
  std::string_view name;
  Quantity quantity = Quantity::number;
  double factor = 1;
};

/// mm um nm m in, deg rad mrad urad arcsec, s min h, degC. nullptr for any other word.
[[nodiscard]] const MeasuredUnit* find_measured_unit(std::string_view name);
/// All of them, for messages: "mm um nm ...".
[[nodiscard]] std::string measured_unit_names();

/// One column: "deviation [um]" has the name `deviation` and the unit um.
struct MeasuredColumn {
  std::string name;
  Quantity quantity = Quantity::number;
  double unit = 1;             ///< internal = unit * number of the file
  std::vector<double> values;  ///< internal units, one per row
};

/// A table of measured numbers, as long as its file.
struct MeasuredTable {
  std::string file;
  std::vector<MeasuredColumn> columns;
  std::vector<std::size_t> lines;  ///< of the rows in the file, from 1

  [[nodiscard]] std::size_t rows() const { return lines.size(); }
  [[nodiscard]] const MeasuredColumn* find(std::string_view name) const;
};

/// Reads a CSV file of measured numbers (docs/measurement-files.md): a header row, then rows with as many
/// cells, separated by commas (semicolons or tabs if the header has no comma). Every column states its unit
/// in brackets, as in "target [mm]", or has none (`run`, `direction`). Lines that begin with # and empty
/// lines are skipped, quotation marks around cells and a byte order mark are removed.
///
/// A cell is a finite number; in the column `direction` it is + or - and becomes +1 or -1.
///
/// errors   E-MEASURED-HEADER (no header, a column without a name or twice, an unknown unit),
///          E-MEASURED-CELL (blank, not a finite number, too few or too many cells); at most 100 are listed
/// laws     TotalOnAnyBytes
/// cost     one pass
[[nodiscard]] Parsed<MeasuredTable> read_measured_table(const std::string& file, std::string_view text);

}  // namespace abbe
