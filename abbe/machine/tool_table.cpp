#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <string_view>

#include "abbe/core/number.h"
#include "abbe/machine/control_setup.h"
#include "abbe/machine/findings.h"

// The tool table of LinuxCNC: one tool per line, words separated by blanks, a comment after ';'.

namespace abbe {
namespace {

constexpr std::string_view kGauge = "gauge";

char upper(char c) { return static_cast<char>(std::toupper(static_cast<unsigned char>(c))); }

bool same_letters(std::string_view a, std::string_view b) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [](char x, char y) { return upper(x) == upper(y); });
}

/// Where "gauge=" (blanks around = allowed) begins as a word of its own, and where its number begins.
struct GaugeWord {
  std::size_t begin = 0, number = 0;
};
std::optional<GaugeWord> find_gauge(std::string_view text) {
  for (std::size_t i = 0; i + kGauge.size() < text.size(); ++i) {
    const bool word_begins =
        i == 0 || (std::isalnum(static_cast<unsigned char>(text[i - 1])) == 0 && text[i - 1] != '_');
    if (!word_begins || !same_letters(text.substr(i, kGauge.size()), kGauge)) continue;
    std::size_t at = text.find_first_not_of(" \t", i + kGauge.size());
    if (at == std::string_view::npos || text[at] != '=') continue;
    at = std::min(text.find_first_not_of(" \t", at + 1), text.size());
    return GaugeWord{i, at};
  }
  return std::nullopt;
}

class TableLine {
 public:
  TableLine(std::size_t number, std::string_view line, Findings& findings)
      : number_(number), line_(line), findings_(findings) {}

  /// nullopt for a line without a tool, and after a reported mistake.
  std::optional<ToolEntry> read() {
    const std::size_t errors_before = findings_.error_count();
    const std::size_t semicolon = std::min(line_.find(';'), line_.size());
    if (line_.find_first_not_of(" \t\r") >= semicolon) return std::nullopt;
    if (semicolon < line_.size()) read_comment(semicolon + 1);
    std::size_t at = 0;
    while (at < semicolon) {
      const std::size_t begin = line_.find_first_not_of(" \t\r", at);
      if (begin >= semicolon) break;
      const std::size_t end = std::min(line_.find_first_of(" \t\r;", begin), semicolon);
      read_word(begin, line_.substr(begin, end - begin));
      at = end;
    }
    if (findings_.error_count() != errors_before) return std::nullopt;
    if (!seen_.contains('T')) {
      findings_.error("E-TOOL-NUMBER", mark(0, line_.size()), "a line without tool number", "",
                      "begin the line with T and the number of the tool");
      return std::nullopt;
    }
    return entry_;
  }

 private:
  [[nodiscard]] Mark mark(std::size_t begin, std::size_t length) const {
    return {number_, begin + 1, length};
  }

  void read_comment(std::size_t begin) {
    const std::string_view comment = line_.substr(begin);
    const std::size_t first = std::min(comment.find_first_not_of(" \t"), comment.size());
    entry_.comment = comment.substr(first, comment.find_last_not_of(" \t\r") + 1 - first);
    const auto gauge = find_gauge(comment);
    if (!gauge) return;
    const std::size_t end = std::min(comment.find_first_of(" \t\r,;)", gauge->number), comment.size());
    read_gauge(begin + gauge->number, comment.substr(gauge->number, end - gauge->number));
  }

  void read_gauge(std::size_t begin, std::string_view text) {
    const auto length = read_number(text);
    if (!length || *length < 0) {
      findings_.error("E-TOOL-GAUGE", mark(begin, text.size()),
                      fmt::format("{} is not a gauge length", in_quotes(text)),
                      "the gauge length is the lever arm of all angular errors",
                      "write the length from the spindle nose to the tip in mm: gauge=112.4");
      return;
    }
    if (entry_.gauge && *entry_.gauge != *length) {
      findings_.error("E-TOOL-GAUGE", mark(begin, text.size()), "two gauge lengths of one tool",
                      "which of them is true cannot be told", "keep one of them");
      return;
    }
    entry_.gauge = length;
  }

  void read_word(std::size_t begin, std::string_view word) {
    const std::size_t equals = word.find('=');
    if (equals != std::string_view::npos && same_letters(word.substr(0, equals), kGauge)) {
      read_gauge(begin + equals + 1, word.substr(equals + 1));
      return;
    }
    constexpr std::string_view kLetters = "TPXYZABCUVWDIJQ";
    const char letter = upper(word.front());
    const auto value = read_number(word.substr(1));
    if (kLetters.find(letter) == std::string_view::npos || !value) {
      findings_.error("E-TOOL-WORD", mark(begin, word.size()),
                      fmt::format("{} is not understood", in_quotes(word)),
                      "a line holds words such as T1 P1 Z100.5 D10, separated by blanks; a comment follows ;",
                      "correct the word, or put it behind ;");
      return;
    }
    if (!seen_.insert(letter).second) {
      findings_.error("E-TOOL-WORD", mark(begin, word.size()), fmt::format("a second {} in one line", letter),
                      "", "keep one of them");
      return;
    }
    store(letter, *value, mark(begin, word.size()));
  }

  void store(char letter, double value, Mark where) {
    switch (letter) {
      case 'T':
      case 'P':
        if (value < 0 || value > std::numeric_limits<int>::max() || value != std::floor(value)) {
          findings_.error("E-TOOL-NUMBER", where, fmt::format("{} is not a whole number from 0", letter), "",
                          "write a whole number");
          return;
        }
        (letter == 'T' ? entry_.number : entry_.pocket) = static_cast<int>(value);
        return;
      case 'X':
      case 'Y':
      case 'Z':
        entry_.offset[static_cast<std::size_t>(letter - 'X')] = value;
        return;
      case 'D':
        entry_.diameter = value;
        return;
      case 'I':
      case 'J':
      case 'Q':
        return;  // shape of turning tools: no effect on positions
      default:
        break;
    }
    if (value != 0) {
      findings_.error("E-TOOL-OFFSET", where, fmt::format("a tool offset in {}", letter),
                      "offsets of axes other than X Y Z are not followed here: positions would be wrong",
                      "set it to 0 and put the offset into the program or the work offset");
    }
  }

  std::size_t number_;
  std::string_view line_;
  Findings& findings_;
  ToolEntry entry_;
  std::set<char> seen_;
};

}  // namespace

Parsed<std::map<int, ToolEntry>> read_tool_table(const std::string& file, const std::string& text) {
  Parsed<std::map<int, ToolEntry>> out;
  Findings findings(file, text, out.diagnostics);
  std::map<int, ToolEntry> tools;
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
  for (std::size_t i = 1; i <= lines && !findings.full(); ++i) {
    const auto entry = TableLine(i, findings.line(i), findings).read();
    if (!entry) continue;
    if (!tools.emplace(entry->number, *entry).second) {
      findings.error("E-TOOL-NUMBER", Mark{i, 1, findings.line(i).size()},
                     fmt::format("tool {} appears twice", entry->number),
                     "which of the two lengths is true cannot be told", "keep one of the lines");
    }
  }
  if (!has_errors(out.diagnostics)) out.value = std::move(tools);
  return out;
}

}  // namespace abbe
