#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "abbe/core/diagnostic.h"

namespace abbe {

/// Collects what is wrong with a file of measurements, with places. After kMost errors the rest is dropped,
/// so that a hostile file cannot fill the memory.
class TextFindings {
 public:
  static constexpr std::size_t kMost = 100;

  explicit TextFindings(std::string file) : file_(std::move(file)) {}

  void error(std::string_view code, std::size_t line, std::string message, std::string why, std::string fix) {
    ++errors_;
    add(Severity::error, code, line, std::move(message), std::move(why), std::move(fix));
  }
  void warning(std::string_view code, std::size_t line, std::string message, std::string why,
               std::string fix) {
    add(Severity::warning, code, line, std::move(message), std::move(why), std::move(fix));
  }

  [[nodiscard]] bool failed() const { return errors_ > 0; }
  [[nodiscard]] bool full() const { return list_.size() >= kMost; }
  [[nodiscard]] Diagnostics take() { return std::move(list_); }

 private:
  void add(Severity severity, std::string_view code, std::size_t line, std::string message, std::string why,
           std::string fix) {
    if (full()) return;
    list_.push_back({severity,
                     std::string(code),
                     {file_, line, line == 0 ? 0U : 1U, 1, {}},
                     std::move(message),
                     std::move(why),
                     std::move(fix)});
  }

  std::string file_;
  Diagnostics list_;
  std::size_t errors_ = 0;
};

}  // namespace abbe
