#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace abbe {

enum class Severity { note, warning, error };

/// Where in a text something was found. line and column count from 1; 0 = the whole file.
struct Place {
  std::string file;
  std::size_t line = 0;
  std::size_t column = 0;
  std::size_t length = 1;   ///< bytes underlined
  std::string source_line;  ///< the text of that line, for the excerpt; may be empty
};

/// One finding about a text, for its author: what was found, why it matters, what to do.
/// `code` is stable and listed in docs/error-codes.md ("E-..." errors, "W-..." warnings).
struct Diagnostic {
  Severity severity = Severity::error;
  std::string code;
  Place place;
  std::string message;
  std::string why;
  std::string fix;
};

using Diagnostics = std::vector<Diagnostic>;

/// A value read from a text. `value` is empty exactly when an error was reported.
template <class T>
struct Parsed {
  std::optional<T> value;
  Diagnostics diagnostics;
};

[[nodiscard]] bool has_errors(const Diagnostics& diagnostics);

/// The compiler form: `file:line:column: error[E-CODE]: message`, the source line with a caret,
/// then `= why:` and `= fix:` lines. Every line ends with a line feed. Control bytes and malformed UTF-8
/// are shown as '?' (a tab as a blank); of a long line the part around the place is shown.
[[nodiscard]] std::string to_text(const Diagnostic& diagnostic);

/// The candidate with the smallest edit distance to `word`, if it is close enough to be a likely
/// misspelling (distance at most 1 for up to 4 letters, 2 for longer ones; case counts half).
[[nodiscard]] std::optional<std::string> closest(std::string_view word,
                                                 const std::vector<std::string>& candidates);

}  // namespace abbe
