#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/diagnostic.h"

namespace abbe {

/// Where something stands in a text: line and column (in characters) from 1; line 0 = the whole text.
struct Mark {
  std::size_t line = 0;
  std::size_t column = 0;
  std::size_t length = 1;
};

/// What a reader finds wrong in one text. Several readers of several texts write to one list.
///
/// errors   after kMaxDiagnostics entries one more says so and the rest is dropped, so that a hostile
///          text cannot fill the memory
class Findings {
 public:
  static constexpr std::size_t kMaxDiagnostics = 500;
  static constexpr std::size_t kLongestExcerpt = 1000;  ///< bytes; longer lines are not quoted

  /// `text` and `out` must outlive the object.
  Findings(std::string file, std::string_view text, Diagnostics& out);

  void error(std::string_view code, Mark mark, std::string message, std::string why, std::string fix);
  void warning(std::string_view code, Mark mark, std::string message, std::string why, std::string fix);

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] std::string_view line(std::size_t number) const;  ///< from 1, without end-of-line bytes
  [[nodiscard]] std::size_t error_count() const { return errors_; }
  [[nodiscard]] bool full() const { return out_.size() > kMaxDiagnostics; }  ///< more work finds nothing more

 private:
  void add(Severity severity, std::string_view code, Mark mark, std::string message, std::string why,
           std::string fix);

  std::string file_;
  std::string_view text_;
  std::vector<std::size_t> line_starts_;
  Diagnostics& out_;
  std::size_t errors_ = 0;
};

/// The word in quotes for a message: control bytes as '?', cut after 60 bytes.
[[nodiscard]] std::string in_quotes(std::string_view word);

/// "did you mean 'EXX'?" for a likely misspelling of one of the candidates, else `otherwise`.
[[nodiscard]] std::string suggestion(std::string_view word, const std::vector<std::string>& candidates,
                                     std::string otherwise);

/// "a, b or c" for messages.
[[nodiscard]] std::string listed(const std::vector<std::string>& words, std::string_view last = "or");

}  // namespace abbe
