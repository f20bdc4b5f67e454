#include "abbe/machine/findings.h"

#include <utility>

namespace abbe {

Findings::Findings(std::string file, std::string_view text, Diagnostics& out)
    : file_(std::move(file)), text_(text), out_(out) {
  line_starts_.push_back(0);
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n') line_starts_.push_back(i + 1);
  }
}

std::string_view Findings::line(std::size_t number) const {
  if (number == 0 || number > line_starts_.size()) return {};
  const std::size_t begin = line_starts_[number - 1];
  const std::size_t end = number < line_starts_.size() ? line_starts_[number] : text_.size();
  std::string_view line = text_.substr(begin, end - begin);
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
  return line;
}

void Findings::add(Severity severity, std::string_view code, Mark mark, std::string message, std::string why,
                   std::string fix) {
  if (severity == Severity::error) ++errors_;
  if (out_.size() > kMaxDiagnostics) return;
  if (out_.size() == kMaxDiagnostics) {
    code = "E-TOO-MANY";
    severity = Severity::error;
    message = "too many mistakes; the rest is not shown";
    why.clear();
    fix = "correct those above and read the file again";
    ++errors_;
  }
  Diagnostic finding;
  finding.severity = severity;
  finding.code = code;
  finding.place.file = file_;
  finding.place.line = mark.line;
  finding.place.column = mark.column;
  finding.place.length = mark.length == 0 ? 1 : mark.length;
  const std::string_view source = line(mark.line);
  if (source.size() <= kLongestExcerpt) finding.place.source_line = source;
  finding.message = std::move(message);
  finding.why = std::move(why);
  finding.fix = std::move(fix);
  out_.push_back(std::move(finding));
}

void Findings::error(std::string_view code, Mark mark, std::string message, std::string why,
                     std::string fix) {
  add(Severity::error, code, mark, std::move(message), std::move(why), std::move(fix));
}

void Findings::warning(std::string_view code, Mark mark, std::string message, std::string why,
                       std::string fix) {
  add(Severity::warning, code, mark, std::move(message), std::move(why), std::move(fix));
}

std::string in_quotes(std::string_view word) {
  constexpr std::size_t kLongest = 60;
  std::string out = "'";
  for (const char c : word.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x20 || byte == 0x7f ? '?' : c;
  }
  out += word.size() > kLongest ? "...'" : "'";
  return out;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& candidates,
                       std::string otherwise) {
  constexpr std::size_t kLongestMisspelling = 64;  // the edit distance costs the product of the lengths
  if (word.size() <= kLongestMisspelling) {
    if (const auto near = closest(word, candidates)) return "did you mean '" + *near + "'?";
  }
  return otherwise;
}

std::string listed(const std::vector<std::string>& words, std::string_view last) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) out += i + 1 == words.size() ? " " + std::string(last) + " " : ", ";
    out += words[i];
  }
  return out;
}

}  // namespace abbe
