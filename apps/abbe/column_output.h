#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "abbe/capture/decode.h"
#include "abbe/core/file.h"
#include "session.h"

namespace abbe::app {

/// A column of numbers over time: its name, and its unit ("" for raw counts).
struct ColumnName {
  std::string name, unit;
  /// "X.position_actual_mm": as CSV and JSON call it.
  [[nodiscard]] std::string label() const;
};

enum class ColumnFormat { csv, json, binary };
/// What --format says, else what the ending of the file says (.csv, .json, .abbecol), else CSV.
[[nodiscard]] ColumnFormat column_format(const std::string& format, const std::string& path);

/// Where the columns come from, for those who read them later.
struct ColumnHeader {
  std::string verb, source, time_base;
  std::vector<ColumnName> columns;  ///< without the time
};

/// Writes columns block by block to a file that appears whole or not at all, or to standard output. The
/// binary form is in docs/theory/captures.md.
class ColumnOutput {
 public:
  /// path empty: standard output. nullopt after reporting why not.
  [[nodiscard]] static std::optional<ColumnOutput> create(const std::string& path, ColumnFormat format,
                                                          ColumnHeader header, Session& session);

  [[nodiscard]] bool write(const ColumnBlock& block);  ///< false: the disk or the reader is gone
  /// Ends the rows. JSON gets `closing` (members, each begun with a comma) behind them.
  [[nodiscard]] bool finish(const std::string& closing_members);

  /// Names of columns that had the same value in every row, of at least two rows.
  [[nodiscard]] std::vector<std::string> constant_columns() const;

 private:
  ColumnOutput(ColumnFormat format, ColumnHeader header, Session& session)
      : format_(format), header_(std::move(header)), session_(&session) {}
  void begin();
  bool put(const std::string& text);

  ColumnFormat format_;
  ColumnHeader header_;
  Session* session_;
  std::optional<SpoolFile> file_;
  std::string text_;
  std::uint64_t rows_ = 0;
  std::vector<double> first_;
  std::vector<char> varies_;
};

}  // namespace abbe::app
