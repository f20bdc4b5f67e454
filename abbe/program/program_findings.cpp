#include "abbe/program/program_findings.h"

#include <fmt/format.h>

#include <utility>

namespace abbe {

void ProgramFindings::add(Severity severity, const std::string& code, std::uint64_t line,
                          std::string_view text, std::size_t column, std::size_t length, std::string message,
                          std::string why, std::string fix) {
  if (severity == Severity::error) ++errors_;
  if (++count_[code] > kPerCode) return;
  Diagnostic d;
  d.severity = severity;
  d.code = code;
  d.place =
      Place{file_, line, line == 0 ? 0 : column + 1, length, std::string(text.substr(0, kMaxBlockBytes))};
  d.message = std::move(message);
  d.why = std::move(why);
  d.fix = std::move(fix);
  list_.push_back(std::move(d));
}

void ProgramFindings::add(const BlockError& error, std::uint64_t line, std::string_view text) {
  add(Severity::error, error.code, line, text, error.column, error.length, error.message, error.why,
      error.fix);
}

void ProgramFindings::add_all_but(const ProgramFindings& other, const std::string& code) {
  for (const Diagnostic& d : other.list()) {
    if (d.code == code) continue;
    errors_ += d.severity == Severity::error ? 1 : 0;
    if (++count_[d.code] <= kPerCode) list_.push_back(d);
  }
}

Diagnostics ProgramFindings::take() {
  for (const auto& [code, count] : count_) {
    if (count <= kPerCode) continue;
    Diagnostic d;
    d.severity = Severity::note;
    d.code = code;
    d.place.file = file_;
    d.message = fmt::format("{} more findings of this kind are not listed", count - kPerCode);
    list_.push_back(std::move(d));
  }
  count_.clear();
  return std::exchange(list_, {});
}

}  // namespace abbe
