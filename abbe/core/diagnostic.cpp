#include "abbe/core/diagnostic.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>

namespace abbe {
namespace {

constexpr std::size_t kExcerpt = 160;  // characters of a long line shown around the place

bool is_continuation(unsigned char c) { return (c & 0xC0U) == 0x80U; }

// Length of the well-formed printable UTF-8 character at text[i], 0 if there is none.
std::size_t character(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char lead = byte(i);
  if (lead < 0x80) return lead >= 0x20 && lead != 0x7F ? 1 : 0;
  const std::size_t length = lead >= 0xF0 && lead <= 0xF4  ? 4
                             : (lead & 0xF0U) == 0xE0      ? 3
                             : lead >= 0xC2 && lead < 0xE0 ? 2
                                                           : 0;
  if (length == 0 || i + length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k) {
    if (!is_continuation(byte(i + k))) return 0;
  }
  const unsigned char second = byte(i + 1);
  if (lead == 0xC2 && second < 0xA0) return 0;  // C1 control bytes
  if (lead == 0xE0 && second < 0xA0) return 0;  // overlong
  if (lead == 0xED && second > 0x9F) return 0;  // surrogates
  if (lead == 0xF0 && second < 0x90) return 0;  // overlong
  if (lead == 0xF4 && second > 0x8F) return 0;  // beyond Unicode
  return length;
}

struct Printable {
  std::string text;
  std::vector<std::size_t> column;  // of each byte of the source (and of its end), in characters from 0
};

// What a terminal may be shown: no control bytes, no malformed UTF-8. A tab becomes one blank.
Printable printable(std::string_view source) {
  Printable out;
  out.text.reserve(source.size());
  out.column.reserve(source.size() + 1);
  std::size_t characters = 0;
  for (std::size_t i = 0; i < source.size();) {
    const std::size_t length = character(source, i);
    if (length == 0) {
      out.text += source[i] == '\t' ? ' ' : '?';
    } else {
      out.text += source.substr(i, length);
    }
    const std::size_t used = std::max<std::size_t>(length, 1);
    out.column.insert(out.column.end(), used, characters);
    i += used;
    ++characters;
  }
  out.column.push_back(characters);
  return out;
}

std::string cut(const std::string& text, std::size_t first, std::size_t count) {
  std::size_t seen = 0, begin = text.size(), end = text.size();
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (is_continuation(static_cast<unsigned char>(text[i]))) continue;
    if (seen == first) begin = i;
    if (seen == first + count) {
      end = i;
      break;
    }
    ++seen;
  }
  return text.substr(begin, end - begin);
}

void append_excerpt(std::string& out, const Place& place, const std::string& number) {
  std::string_view source = place.source_line;
  while (!source.empty() && (source.back() == '\n' || source.back() == '\r')) source.remove_suffix(1);
  const Printable shown = printable(source);

  const std::size_t at = std::min(place.column == 0 ? 0 : place.column - 1, source.size());
  const std::size_t last = std::min(at + std::min(place.length, source.size()), source.size());
  const std::size_t caret = shown.column[at];
  const std::size_t under = std::max<std::size_t>(shown.column[last] - caret, 1);
  const std::size_t total = shown.column.back();

  const std::size_t first = total > kExcerpt && caret > kExcerpt / 2 ? caret - kExcerpt / 2 : 0;
  const std::string before = first > 0 ? "..." : "";
  const std::string after = total > first + kExcerpt ? "..." : "";
  out += fmt::format(" {} | {}{}{}\n", number, before, cut(shown.text, first, kExcerpt), after);
  if (place.column == 0) return;
  const std::size_t room = first + kExcerpt - std::min(caret, first + kExcerpt);
  out += fmt::format(" {} | {}^{}\n", std::string(number.size(), ' '),
                     std::string(before.size() + caret - first, ' '),
                     std::string(std::min(under, std::max<std::size_t>(room, 1)) - 1, '~'));
}

constexpr int kEdit = 2;       // costs in halves
constexpr int kOtherCase = 1;  // the same letter, capital or small

constexpr char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// Optimal string alignment distance: insertions, deletions, substitutions, swaps of neighbours.
int edit_distance(std::string_view a, std::string_view b) {
  std::array<std::vector<int>, 3> rows;  // the one before the last, the last, this one
  for (auto& row : rows) row.resize(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) rows[1][j] = static_cast<int>(j) * kEdit;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    rows[2][0] = static_cast<int>(i) * kEdit;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int change = a[i - 1] == b[j - 1] ? 0 : lower(a[i - 1]) == lower(b[j - 1]) ? kOtherCase : kEdit;
      int best = std::min({rows[1][j - 1] + change, rows[1][j] + kEdit, rows[2][j - 1] + kEdit});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        best = std::min(best, rows[0][j - 2] + kEdit);
      rows[2][j] = best;
    }
    std::rotate(rows.begin(), rows.begin() + 1, rows.end());
  }
  return rows[1][b.size()];
}

}  // namespace

bool has_errors(const Diagnostics& diagnostics) {
  return std::any_of(diagnostics.begin(), diagnostics.end(),
                     [](const Diagnostic& d) { return d.severity == Severity::error; });
}

std::string to_text(const Diagnostic& diagnostic) {
  const Place& place = diagnostic.place;
  std::string out;
  if (!place.file.empty()) {
    out += printable(place.file).text;
    if (place.line > 0) out += fmt::format(":{}", place.line);
    if (place.line > 0 && place.column > 0) out += fmt::format(":{}", place.column);
    out += ": ";
  }
  out += diagnostic.severity == Severity::error     ? "error"
         : diagnostic.severity == Severity::warning ? "warning"
                                                    : "note";
  if (!diagnostic.code.empty()) out += fmt::format("[{}]", diagnostic.code);
  out += fmt::format(": {}\n", printable(diagnostic.message).text);

  const std::string number = place.line > 0 ? fmt::format("{}", place.line) : "";
  if (place.line > 0 && !place.source_line.empty()) append_excerpt(out, place, number);
  const std::string margin(number.size() + 2, ' ');
  if (!diagnostic.why.empty()) out += fmt::format("{}= why: {}\n", margin, printable(diagnostic.why).text);
  if (!diagnostic.fix.empty()) out += fmt::format("{}= fix: {}\n", margin, printable(diagnostic.fix).text);
  return out;
}

std::optional<std::string> closest(std::string_view word, const std::vector<std::string>& candidates) {
  const int allowed = word.size() <= 4 ? kEdit : 2 * kEdit;
  std::optional<std::string> best;
  int best_distance = allowed + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t longer = std::max(word.size(), candidate.size());
    const std::size_t shorter = std::min(word.size(), candidate.size());
    if ((longer - shorter) * kEdit > static_cast<std::size_t>(allowed)) continue;
    const int distance = edit_distance(word, candidate);
    const bool something_kept = static_cast<std::size_t>(distance) < kEdit * longer;
    if (something_kept && distance < best_distance) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace abbe
