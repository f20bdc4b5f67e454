#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"

// The reader of the verification: it shares number parsing with the rewriter's and nothing else.
namespace abbe::cl::verifying {

/// A field of a statement: its text, and its value if all of it is a number.
struct Field {
  std::string text;  ///< upper case
  std::optional<double> value;
};

/// One statement: a remark, a word alone, or a word and fields.
struct Statement {
  std::uint64_t line = 0;
  std::string bytes;  ///< as in the file
  std::string word;   ///< upper case; empty for remarks and blank lines
  bool free_text = false;
  std::vector<Field> fields;
  std::string
      skeleton;  ///< the bytes with '#' for each number, continuations and blanks taken out, remarks kept
  std::string remark;  ///< behind `$$`

  [[nodiscard]] std::size_t count() const { return fields.size(); }
  /// The first fields, if all of them are numbers.
  [[nodiscard]] bool numbers(std::size_t count) const;
  [[nodiscard]] double at(std::size_t field) const { return fields[field].value.value_or(0); }
  [[nodiscard]] bool has(std::string_view text) const;
};

/// Findings about one file.
Diagnostic finding(const std::string& file, const Statement& at, const char* code, std::string message,
                   std::string why, std::string fix);

/// Reads a file statement by statement.
class StatementReader {
 public:
  StatementReader(LineReader reader, std::string name) : reader_(std::move(reader)), name_(std::move(name)) {}

  /// The next statement; nullopt at the end of the file or after a fault.
  [[nodiscard]] std::optional<Statement> next();
  [[nodiscard]] const std::optional<Diagnostic>& fault() const { return fault_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] LineReader& file() { return reader_; }

 private:
  LineReader reader_;
  std::string name_;
  std::optional<Diagnostic> fault_;
};

}  // namespace abbe::cl::verifying
