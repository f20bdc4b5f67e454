#include "abbe/machine/chain_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

// The lower-body array has as many rows as the longest branch and one column per body.
constexpr std::size_t kMostElements = 100;

constexpr std::string_view kGrammar = "a chain is written from the workpiece through the bed to the tool";
constexpr std::string_view kExample = "write it like \"w C X b Y Z A t\"";

struct Word {
  std::string_view text;
  Mark mark;
};

/// The blank-separated words of the text with their places inside the quotes, as far as the source
/// line shows the text as it is (no escapes, one line).
std::vector<Word> words_of(const TomlNode& node, const Findings& findings) {
  const std::string_view text = node.text;
  const std::string_view line = findings.line(node.mark.line);
  const bool verbatim = node.mark.column >= 1 && node.mark.column <= line.size() &&
                        line.substr(node.mark.column).substr(0, text.size()) == text;
  std::vector<Word> words;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t begin = text.find_first_not_of(" \t", at);
    if (begin == std::string_view::npos) break;
    const std::size_t end = std::min(text.find_first_of(" \t", begin), text.size());
    const Mark inside{node.mark.line, node.mark.column + 1 + begin, end - begin};
    words.push_back({text.substr(begin, end - begin), verbatim ? inside : node.mark});
    at = end;
  }
  return words;
}

bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_element(std::string_view name) {
  return !name.empty() && is_capital(name.front()) && std::all_of(name.begin() + 1, name.end(), is_digit);
}

void report_bad_element(const Word& word, Findings& findings) {
  if (word.text == "w" || word.text == "t") {
    findings.error("E-CHAIN-ENDS", word.mark, fmt::format("'{}' in the middle of the chain", word.text),
                   std::string(kGrammar), "the chain begins with w and ends with t, each once");
    return;
  }
  std::string upper(word.text);
  if (!upper.empty())
    upper.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(upper.front())));
  findings.error("E-CHAIN-ELEMENT", word.mark, fmt::format("{} is not a chain element", in_quotes(word.text)),
                 "an element is a capital letter, then digits: X, Z1, B12",
                 is_element(upper) ? "did you mean " + in_quotes(upper) + "?" : std::string(kExample));
}

}  // namespace

std::optional<std::vector<ChainElement>> read_chain(const TomlNode& node, Findings& findings) {
  if (!expect_kind(node, TomlNode::Kind::text, "machine.chain", findings)) return std::nullopt;
  const std::vector<Word> words = words_of(node, findings);
  const std::size_t errors_before = findings.error_count();
  if (words.size() > kMostElements + 3) {
    findings.error("E-CHAIN-ELEMENT", node.mark, fmt::format("a chain of {} elements", words.size() - 3),
                   fmt::format("more than {} bodies are not supported", kMostElements), "shorten the chain");
    return std::nullopt;
  }
  if (words.empty()) {
    findings.error("E-CHAIN-ENDS", node.mark, "the chain is empty", std::string(kGrammar),
                   std::string(kExample));
    return std::nullopt;
  }
  if (words.front().text != "w") {
    findings.error("E-CHAIN-ENDS", words.front().mark, "the chain does not begin with w",
                   std::string(kGrammar), std::string(kExample));
  }
  if (words.size() < 2 || words.back().text != "t") {
    findings.error("E-CHAIN-ENDS", words.back().mark, "the chain does not end with t", std::string(kGrammar),
                   std::string(kExample));
  }

  std::vector<ChainElement> elements;
  std::size_t beds = 0;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const Word& word = words[i];
    if ((i == 0 && word.text == "w") || (i + 1 == words.size() && word.text == "t")) continue;
    if (word.text == "b") {
      if (++beds == 2) {
        findings.error("E-CHAIN-BED", word.mark, "a second b in the chain", "a machine has one bed",
                       "keep the b between the workpiece branch and the tool branch");
      }
      continue;
    }
    std::string_view name = word.text;
    if (name.size() > 1 && name.back() == '\'') name.remove_suffix(1);
    if (!is_element(name)) {
      report_bad_element(word, findings);
      continue;
    }
    if (std::any_of(elements.begin(), elements.end(),
                    [&](const auto& other) { return other.name == name; })) {
      findings.error("E-CHAIN-DUPLICATE", word.mark,
                     fmt::format("{} appears twice in the chain", in_quotes(name)),
                     "errors and positions are addressed by this name",
                     fmt::format("give the second one a number of its own, such as {}1", name.substr(0, 1)));
      continue;
    }
    elements.push_back({std::string(name), beds == 0 ? Branch::workpiece : Branch::tool, word.mark});
  }
  if (beds == 0) {
    findings.error("E-CHAIN-BED", node.mark, "no b in the chain",
                   "b, the bed, separates the axes that carry the workpiece from those that carry the tool",
                   std::string(kExample));
  }
  if (findings.error_count() != errors_before) return std::nullopt;
  return elements;
}

std::optional<LetterDefaults> letter_defaults(char letter) {
  switch (letter) {
    case 'X':
    case 'U':
      return LetterDefaults{AxisType::linear, Vec3::UnitX()};
    case 'Y':
    case 'V':
      return LetterDefaults{AxisType::linear, Vec3::UnitY()};
    case 'Z':
    case 'W':
      return LetterDefaults{AxisType::linear, Vec3::UnitZ()};
    case 'A':
      return LetterDefaults{AxisType::rotary, Vec3::UnitX()};
    case 'B':
      return LetterDefaults{AxisType::rotary, Vec3::UnitY()};
    case 'C':
      return LetterDefaults{AxisType::rotary, Vec3::UnitZ()};
    case 'S':
      return LetterDefaults{AxisType::fixed, Vec3::UnitZ()};
    default:
      return std::nullopt;
  }
}

}  // namespace abbe
