#include "abbe/verify/block.h"

#include <fmt/format.h>

#include <cmath>

#include "abbe/core/number.h"
#include "abbe/verify/klartext_words.h"
#include "abbe/verify/named_words.h"
#include "abbe/verify/word_taker.h"

namespace abbe::verifying {
namespace {

constexpr Letters kPlainLetters = kValueLetters & ~letters('N');

constexpr bool is_blank(char c) { return c == ' ' || c == '\t'; }
constexpr bool is_number_start(char c) { return (c >= '0' && c <= '9') || c == '.' || c == '+' || c == '-'; }

/// A number with blanks inside: blanks taken out, then read as usual. Sets the characters used.
Decimal read_spaced_decimal(std::string_view text) {
  std::array<char, kMaxBlockLength + 1> packed;
  std::array<std::uint8_t, kMaxBlockLength + 1> origin;
  std::size_t n = 0;
  for (std::size_t i = 0; i < text.size() && n < packed.size(); ++i) {
    if (is_blank(text[i])) continue;
    if (!is_number_start(text[i])) break;
    packed[n] = text[i];
    origin[n++] = static_cast<std::uint8_t>(i);
  }
  Decimal decimal = read_decimal({packed.data(), n});
  if (decimal.length > 0) decimal.length = static_cast<std::size_t>(origin[decimal.length - 1]) + 1;
  return decimal;
}

/// Usual words: a value letter, at once its number, then the end or a blank and the next letter. Reads as
/// many as there are from p on and returns where they end.
const char* plain_words(const char* begin, const char* p, const char* end, Block& block) {
  Letters words = block.words;
  while (p != end) {
    const auto letter = static_cast<unsigned>(*p) - 'A';
    if (letter >= 26 || (kPlainLetters & ~words & (Letters{1} << letter)) == 0) break;
    double number = 0;
    int decimals = 0;
    const char* next = read_plain_decimal(begin, p + 1, end, number, decimals);
    if (next == nullptr) break;
    if (next != end && *next == ' ') ++next;
    const bool ends = next == end || static_cast<unsigned>(*next) - 'A' < 26;
    if (!ends || !(std::abs(number) <= kMaxNumber)) break;
    words |= Letters{1} << letter;
    block.value[letter] = number;
    block.column[letter] = static_cast<std::uint8_t>(p - begin + 1);
    p = next;
  }
  block.words = words;
  return p;
}

class Scanner : public WordTaker {
 public:
  using WordTaker::WordTaker;

  bool scan() {
    bool first = at_ == 0;
    if (first) skip_blanks();
    if (first && at_ < line_.size() && line_[at_] == '/') {
      if (profile_.text.skip == Profile::Skip::none) return stray('/');
      block_.deletable = true;
      ++at_;
      const bool numbered = profile_.text.skip == Profile::Skip::numbered;
      if (numbered && at_ < line_.size() && line_[at_] >= '1' && line_[at_] <= '9') ++at_;
    }
    while (at_ < line_.size()) {
      const char c = line_[at_];
      if (is_blank(c)) {
        ++at_;
        continue;
      }
      const char upper = static_cast<char>(static_cast<unsigned char>(c) & 0xDFu);
      if (upper >= 'A' && upper <= 'Z') {
        const char* const begin = line_.data();
        const char* const behind = plain_words(begin, begin + at_, begin + line_.size(), block_);
        const bool plain = behind != begin + at_;
        at_ = static_cast<std::size_t>(behind - begin);
        if (!plain && !word(upper, first)) return false;
        first = false;
      } else if ((c == '(' && profile_.text.parentheses) || (c == ';' && profile_.text.semicolon)) {
        if (!comment(c)) return false;
      } else {
        return stray(c);
      }
    }
    return true;
  }

 private:
  void skip_blanks() {
    while (at_ < line_.size() && is_blank(line_[at_])) ++at_;
  }

  bool comment(char open) {
    std::size_t end = line_.size();
    if (open == '(') {
      const std::size_t close = line_.find(')', at_);
      const std::size_t nested = line_.find('(', at_ + 1);
      if (close == std::string_view::npos)
        return refuse(
            fault_, at_ + 1, line_.size() - at_, "E-COMMENT", "the comment is not closed on its line",
            "the control would read the rest of the line as text or stop here", "close it with ')'");
      if (nested < close)
        return refuse(fault_, nested + 1, 1, "E-COMMENT", "'(' inside a comment",
                      "comments do not nest: controls disagree where this one ends",
                      "use other brackets inside");
      end = close + 1;
    }
    block_.comments[static_cast<std::size_t>(block_.comment_count++)] = line_.substr(at_, end - at_);
    at_ = end;
    return true;
  }

  bool stray(char c) {
    if (c == '#' || c == '[' || c == '=' || c == '<' || c == ']' || c == '>') return expression();
    const auto byte = static_cast<unsigned char>(c);
    if (c == '*')
      return refuse(fault_, at_ + 1, 1, "E-CHAR", "the checksum of a line", "it is of the line as it was",
                    "write the program without checksums");
    return refuse(fault_, at_ + 1, 1, "E-CHAR",
                  byte > 0x20 && byte < 0x7f
                      ? fmt::format("'{}' outside a comment and without a word letter", c)
                      : fmt::format("byte 0x{:02x} outside a comment", byte),
                  "its meaning is not known, so what the block does is not known either",
                  "remove it or put it into a comment");
  }

  bool expression() {
    return refuse(fault_, at_ + 1, 1, "E-EXPR", "variables and expressions are not read",
                  "their value is known only to the control", "post the program with literal numbers");
  }

  bool word(char letter, bool first) {
    const std::size_t column = at_ + 1;
    ++at_;
    skip_blanks();
    if (letter == 'O')
      return refuse(fault_, column, 1, "E-OWORD", "O word",
                    "subprograms and loops are not followed; only a program number at the start is",
                    "expand the program before it is compensated");
    if (at_ < line_.size() &&
        (line_[at_] == '#' || line_[at_] == '[' || line_[at_] == '=' || line_[at_] == '<'))
      return expression();

    // Contiguous numbers take the fast way; a blank inside one is legal and rare.
    Decimal number = read_decimal(line_.substr(at_));
    std::size_t next = at_ + number.length;
    while (next < line_.size() && is_blank(line_[next])) ++next;
    if ((number.length == 0 || next > at_ + number.length) && next < line_.size() &&
        is_number_start(line_[next]))
      number = read_spaced_decimal(line_.substr(at_));
    if (number.length == 0)
      return refuse(fault_, column, 1, "E-NUMBER", fmt::format("no number after {}", letter),
                    "a word is a letter and a number", "complete the word");
    at_ += number.length;
    next = at_;
    while (next < line_.size() && is_blank(line_[next])) ++next;
    if (next < line_.size() && is_number_start(line_[next]))
      return refuse(fault_, next + 1, 1, "E-NUMBER",
                    fmt::format("the number after {} goes on strangely", letter),
                    "two points or signs in one number", "write one number per word");
    if (!(std::abs(number.value) <= kMaxNumber))
      return refuse(fault_, column, at_ + 1 - column, "E-NUMBER", "the number is too large",
                    "no machine goes there", "correct the number");

    if (letter == 'G') return g_word(number.value, column);
    if (letter == 'M') return m_word(number.value, column);
    return value_word(letter, number.value, column, first);
  }
};

/// The words whose number stands without a point; zeros are the same either way.
Letters words_without_point(std::string_view line, const Block& block) {
  Letters found = 0;
  for (std::size_t i = 0; i < 26; ++i) {
    if ((block.words >> i & 1) == 0 || block.value[i] == 0) continue;
    std::size_t at = block.column[i];  // columns count from 1: this is behind the letter
    bool point = false;
    for (; at < line.size() && (is_blank(line[at]) || is_number_start(line[at])); ++at)
      point = point || line[at] == '.';
    if (!point) found |= Letters{1} << i;
  }
  return found;
}

/// Every control reads lines up to here.
constexpr std::size_t kEverywhere = 60;
/// A scale, whose factor is another one without a point.
constexpr int kScale = 510;

/// What not every control allows of a line that was split into words.
bool read_rules(std::string_view line, const Profile& profile, Block& block, Fault& fault) {
  const bool words = block.words != 0 || block.g_groups != 0 || block.m_groups != 0;
  if (words && line.size() > profile.text.block_bytes)
    return refuse(
        fault, profile.text.block_bytes + 1, 1, "E-LINELEN",
        fmt::format("the line has {} bytes, the control reads {}", line.size(), profile.text.block_bytes),
        "the control stops at longer lines", "shorten the line");
  if (profile.numbers.integer_words != Profile::IntegerWords::units || block.g_code(11) == kScale)
    block.pointless = words_without_point(line, block);
  return true;
}

}  // namespace

bool read_block(std::string_view line, const Profile& profile, Block& block, Fault& fault,
                std::span<const TcpCode> tcp_codes, Continued continued) {
  block.words = 0;
  block.g_groups = 0;
  block.m_groups = block.m_after = 0;
  block.extra_count = 0;
  block.pointless = 0;
  block.tcp_code = -1;
  block.deletable = false;
  block.comment_count = 0;
  block.increments = block.places = 0;
  block.pole = Block::Pole::none;
  block.hole.cycle = block.hole.count = 0;
  block.hole_begins = block.tool_data = false;
  block.flow = Block::Flow::none;
  if (profile.text.conversational)
    return read_klartext_words(line, profile, continued, block, fault, tcp_codes);
  if (profile.text.names) return read_named_words(line, profile, block, fault, tcp_codes);
  if (line.size() > kMaxBlockLength)
    return refuse(fault, kMaxBlockLength + 1, 1, "E-LINELEN",
                  fmt::format("the line has {} bytes, the control reads {}", line.size(), kMaxBlockLength),
                  "controls stop at longer lines", "shorten the line");
  const char* const begin = line.data();
  const char* const behind = plain_words(begin, begin, begin + line.size(), block);
  const auto plain = static_cast<std::size_t>(behind - begin);
  if (plain != line.size() && !Scanner(line, plain, profile, block, fault, tcp_codes).scan()) return false;
  const bool usual = line.size() <= kEverywhere &&
                     profile.numbers.integer_words == Profile::IntegerWords::units &&
                     block.g_code(11) != kScale;
  return usual || read_rules(line, profile, block, fault);
}

}  // namespace abbe::verifying
