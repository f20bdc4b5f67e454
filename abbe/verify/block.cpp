#include "abbe/verify/block.h"

#include <fmt/format.h>

#include <cmath>

#include "abbe/core/number.h"

namespace abbe::verifying {
namespace {

bool refuse(Fault& fault, std::size_t column, std::size_t length, const char* code, std::string message,
            std::string why, std::string fix) {
  fault = {code, column, length, std::move(message), std::move(why), std::move(fix)};
  return false;
}

constexpr Letters kValueLetters =
    letters('N', 'T', 'S', 'F', 'D', 'H', 'L', 'P', 'Q', 'R', 'X', 'Y', 'Z', 'I', 'J', 'K', 'A', 'B', 'C');

constexpr Letters kPlainLetters = kValueLetters & ~letters('N');

constexpr bool is_blank(char c) { return c == ' ' || c == '\t'; }
constexpr bool is_number_start(char c) { return (c >= '0' && c <= '9') || c == '.' || c == '+' || c == '-'; }

/// LinuxCNC's modal group of a G code (times 10), -1 if the code is not understood.
constexpr int g_group(int code) {
  switch (code) {
    case 40:
    case 100:
    case 280:
    case 300:
    case 520:
    case 530:
    case 920:
    case 921:
    case 922:
    case 923:
      return 0;
    case 0:
    case 10:
    case 20:
    case 30:
    case 800:
    case 730:
    case 740:
    case 810:
    case 820:
    case 830:
    case 840:
    case 850:
    case 860:
    case 890:
      return 1;
    case 170:
    case 180:
    case 190:
      return 2;
    case 900:
    case 910:
      return 3;
    case 901:
    case 911:
      return 4;
    case 930:
    case 940:
    case 950:
      return 5;
    case 200:
    case 210:
      return 6;
    case 400:
      return 7;
    case 430:
    case 431:
    case 490:
      return 8;
    case 980:
    case 990:
      return 10;
    case 540:
    case 550:
    case 560:
    case 570:
    case 580:
    case 590:
    case 591:
    case 592:
    case 593:
      return 12;
    case 610:
    case 611:
    case 640:
      return 13;
    case 960:
    case 970:
      return 14;
    case 80:
      return 15;
    default:
      return -1;
  }
}

/// LinuxCNC's modal group of an M code, -1 if the code is not understood.
constexpr int m_group(int code) {
  switch (code) {
    case 0:
    case 1:
    case 2:
    case 30:
    case 60:
      return Block::kStops;
    case 62:
    case 63:
    case 64:
    case 65:
    case 66:
    case 67:
    case 68:
      return 5;
    case 6:
    case 61:
      return 6;
    case 3:
    case 4:
    case 5:
    case 19:
      return 7;
    case 7:
    case 8:
    case 9:
      return 8;
    case 48:
    case 49:
    case 50:
    case 51:
    case 52:
    case 53:
      return 9;
    default:
      return -1;
  }
}

/// A value that is meant to be whole: within 1e-4 of an integer, as LinuxCNC reads codes.
bool whole(double value, int& out) {
  const double nearest = std::round(value);
  if (!(std::abs(value - nearest) <= 1e-4) || std::abs(nearest) > 1e6) return false;
  out = static_cast<int>(nearest);
  return true;
}

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

class Scanner {
 public:
  Scanner(std::string_view line, Block& block, Fault& fault, std::span<const TcpCode> tcp_codes)
      : line_(line), block_(block), fault_(fault), tcp_codes_(tcp_codes) {}

  bool scan() {
    skip_blanks();
    if (at_ < line_.size() && line_[at_] == '/') {
      block_.deletable = true;
      ++at_;
    }
    bool first = true;
    while (at_ < line_.size()) {
      const char c = line_[at_];
      if (is_blank(c)) {
        ++at_;
        continue;
      }
      const char upper = static_cast<char>(static_cast<unsigned char>(c) & 0xDFu);
      if (upper >= 'A' && upper <= 'Z') {
        if (!plain_words() && !word(upper, first)) return false;
        first = false;
      } else if (c == '(' || c == ';') {
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

  /// Usual words: a value letter, at once its number, then the end or a blank and the next letter. Reads as
  /// many as there are; false: none.
  bool plain_words() {
    const char* const begin = line_.data();
    const char* const end = begin + line_.size();
    const char* p = begin + at_;
    Letters words = block_.words;
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
      block_.value[letter] = number;
      block_.column[letter] = static_cast<std::uint8_t>(p - begin + 1);
      p = next;
    }
    if (p == begin + at_) return false;
    block_.words = words;
    at_ = static_cast<std::size_t>(p - begin);
    return true;
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

  bool g_word(double value, std::size_t column) {
    int code = -1;
    if (!whole(value * 10, code)) code = -1;
    const bool switches = tcp_switch('G', code);
    if (switches && code == 434) code = 430;  // G43.4 H applies the tool length as G43 does
    const int group = g_group(code);
    if (switches && group < 0) return true;
    const std::size_t length = at_ + 1 - column;
    if (group < 0) {
      if (code == 410 || code == 411 || code == 420 || code == 421)
        return refuse(fault_, column, length, "E-CUTCOM", "cutter radius compensation",
                      "the control shifts the path by the tool radius, which is not followed here",
                      "post the program with the tool centre path (compensation off)");
      return refuse(fault_, column, length, "E-GCODE", fmt::format("G{:g} is not understood", value),
                    "an unknown code may move the machine or change a frame",
                    "post the program without it (docs/programs.md lists the codes known)");
    }
    const std::uint32_t bit = std::uint32_t{1} << group;
    if ((block_.g_groups & bit) != 0) {
      // LinuxCNC lets G80 stand beside another motion code, which then counts alone.
      constexpr int no_motion = 800;
      if (code == no_motion) return true;
      if (block_.g[static_cast<std::size_t>(group)] != no_motion)
        return refuse(fault_, column, length, "E-BLOCK",
                      fmt::format("G{:g}: two codes of one group in a block", value),
                      "they contradict each other", "use two blocks");
    }
    block_.g_groups |= bit;
    block_.g[static_cast<std::size_t>(group)] = static_cast<std::int16_t>(code);
    block_.g_column[static_cast<std::size_t>(group)] = static_cast<std::uint8_t>(column);
    return true;
  }

  /// Notes a code that switches tool centre point control; false: it is none.
  bool tcp_switch(char letter, int code) {
    for (const TcpCode& known : tcp_codes_) {
      if (known.letter != letter || known.code != code) continue;
      block_.tcp_letter = letter;
      block_.tcp_code = code;
      block_.tcp = known.on;
      return true;
    }
    return false;
  }

  bool m_word(double value, std::size_t column) {
    int code = -1;
    if (!whole(value, code)) code = -1;
    if (tcp_switch('M', 10 * code)) return true;
    const int group = m_group(code);
    const std::size_t length = at_ + 1 - column;
    if (group < 0)
      return refuse(fault_, column, length, "E-MCODE", fmt::format("M{:g} is not understood", value),
                    "user M codes may move the machine or change its state",
                    "take it out (docs/programs.md lists the codes known)");
    const std::uint32_t bit = std::uint32_t{1} << group;
    if ((block_.m_groups & bit) != 0)
      return refuse(fault_, column, length, "E-BLOCK",
                    fmt::format("M{:g}: two codes of one group in a block", value),
                    "their order is not defined", "use two blocks");
    block_.m_groups |= bit;
    block_.m[static_cast<std::size_t>(group)] = static_cast<std::int16_t>(code);
    block_.m_column[static_cast<std::size_t>(group)] = static_cast<std::uint8_t>(column);
    return true;
  }

  bool value_word(char letter, double value, std::size_t column, bool first) {
    const std::size_t length = at_ + 1 - column;
    const Letters bit = letter_bit(letter);
    if ((kValueLetters & bit) == 0) {
      if (letter == 'U' || letter == 'V' || letter == 'W')
        return refuse(fault_, column, length, "E-AXIS", fmt::format("secondary axis word {}", letter),
                      "only X Y Z and A B C are compensated in programs", "program without it");
      return refuse(fault_, column, length, "E-WORD", fmt::format("word {} is not understood", letter),
                    "an unknown word may change what the block does", "remove it");
    }
    if ((block_.words & bit) != 0)
      return refuse(fault_, column, length, "E-BLOCK", fmt::format("two {} words in a block", letter),
                    "it is not defined which one holds", "keep one");
    if (letter == 'N' && !first)
      return refuse(fault_, column, length, "E-BLOCK", "N word after other words",
                    "the block number comes first", "move it to the start of the block");
    block_.words |= bit;
    block_.value[static_cast<std::size_t>(letter - 'A')] = value;
    block_.column[static_cast<std::size_t>(letter - 'A')] = static_cast<std::uint8_t>(column);
    return true;
  }

  std::string_view line_;
  Block& block_;
  Fault& fault_;
  std::span<const TcpCode> tcp_codes_;
  std::size_t at_ = 0;
};

}  // namespace

bool read_block(std::string_view line, Block& block, Fault& fault, std::span<const TcpCode> tcp_codes) {
  block.words = 0;
  block.g_groups = 0;
  block.m_groups = 0;
  block.tcp_code = -1;
  block.deletable = false;
  block.comment_count = 0;
  if (line.size() > kMaxBlockLength)
    return refuse(fault, kMaxBlockLength + 1, 1, "E-LINELEN",
                  fmt::format("the line has {} bytes, the control reads {}", line.size(), kMaxBlockLength),
                  "LinuxCNC stops at longer lines", "shorten the line");
  return Scanner(line, block, fault, tcp_codes).scan();
}

}  // namespace abbe::verifying
