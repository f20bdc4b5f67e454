#include "abbe/verify/block.h"

#include <fmt/format.h>

#include <cmath>

#include "abbe/core/number.h"

namespace abbe::verifying {
namespace {

[[gnu::cold]] bool refuse(Fault& fault, std::size_t column, std::size_t length, const char* code, std::string message,
            std::string why, std::string fix) {
  fault = {code, column, length, std::move(message), std::move(why), std::move(fix)};
  return false;
}

constexpr Letters kValueLetters =
    letters('N', 'T', 'S', 'F', 'D', 'H', 'L', 'P', 'Q', 'R', 'X', 'Y', 'Z', 'I', 'J', 'K', 'A', 'B', 'C');

constexpr Letters kPlainLetters = kValueLetters & ~letters('N');

constexpr bool is_blank(char c) { return c == ' ' || c == '\t'; }
constexpr bool is_number_start(char c) { return (c >= '0' && c <= '9') || c == '.' || c == '+' || c == '-'; }

/// Where a meaning goes in a block: its modal group as in LinuxCNC, and the code by which this reader knows it.
struct Seat {
  std::int8_t group = -1;
  std::int16_t code = 0;
};
constexpr std::int8_t kNoGroup = -2;

constexpr Seat seat_of(Meaning meaning) {
  switch (meaning) {
    case Meaning::unknown: break;
    case Meaning::dwell: return {0, 40};
    case Meaning::set_data: return {0, 100};
    case Meaning::home: return {0, 280};
    case Meaning::other_home: return {0, 300};
    case Meaning::local_shift: return {0, 520};
    case Meaning::machine_coordinates: return {0, 530};
    case Meaning::set_position: return {0, 920};
    case Meaning::clear_position: return {0, 921};
    case Meaning::suspend_position: return {0, 922};
    case Meaning::restore_position: return {0, 923};
    case Meaning::rapid: return {1, 0};
    case Meaning::line: return {1, 10};
    case Meaning::arc_cw: return {1, 20};
    case Meaning::arc_ccw: return {1, 30};
    case Meaning::no_motion: return {1, 800};
    case Meaning::chip_break: return {1, 730};
    case Meaning::tap_left: return {1, 740};
    case Meaning::fine_bore: return {1, 760};
    case Meaning::drill: return {1, 810};
    case Meaning::drill_dwell: return {1, 820};
    case Meaning::peck: return {1, 830};
    case Meaning::tap: return {1, 840};
    case Meaning::bore: return {1, 850};
    case Meaning::bore_stop: return {1, 860};
    case Meaning::bore_dwell: return {1, 890};
    case Meaning::plane_xy: return {2, 170};
    case Meaning::plane_zx: return {2, 180};
    case Meaning::plane_yz: return {2, 190};
    case Meaning::absolute: return {3, 900};
    case Meaning::incremental: return {3, 910};
    case Meaning::centre_absolute: return {4, 901};
    case Meaning::centre_incremental: return {4, 911};
    case Meaning::inverse_time: return {5, 930};
    case Meaning::per_minute: return {5, 940};
    case Meaning::per_turn: return {5, 950};
    case Meaning::units_inch: return {6, 200};
    case Meaning::units_mm: return {6, 210};
    case Meaning::cutter_off: return {7, 400};
    case Meaning::tool_length: return {8, 430};
    case Meaning::tool_length_minus: return {8, 440};
    case Meaning::tool_length_direct: return {8, 431};
    case Meaning::tool_length_off: return {8, 490};
    case Meaning::retract_initial: return {10, 980};
    case Meaning::retract_r: return {10, 990};
    case Meaning::rotate: return {11, 680};
    case Meaning::rotate_off: return {11, 690};
    case Meaning::work_offset: return {12, 0};
    case Meaning::numbered_work_offset: return {12, Block::kFurtherOffset};
    case Meaning::path_control: return {13, -1};
    case Meaning::spindle_mode: return {14, -1};
    case Meaning::radius_mode: return {15, -1};
    case Meaning::exact_stop_once:
    case Meaning::transformation_off:
    case Meaning::smoothing:
    case Meaning::copy:
    case Meaning::auxiliary: return {kNoGroup, -1};
    case Meaning::stop:
    case Meaning::end: return {Block::kStops, -1};
    case Meaning::signal: return {5, -1};
    case Meaning::tool_change: return {6, 6};
    case Meaning::set_tool: return {6, 61};
    case Meaning::spindle: return {7, -1};
    case Meaning::coolant: return {8, -1};
    case Meaning::override_switch: return {9, -1};
  }
  return {};
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

/// Usual words: a value letter, at once its number, then the end or a blank and the next letter. Reads as many as
/// there are from p on and returns where they end.
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

class Scanner {
 public:
  /// `at` bytes were plain words.
  Scanner(std::string_view line, std::size_t at, const Profile& profile, Block& block, Fault& fault,
          std::span<const TcpCode> tcp_codes)
      : line_(line), profile_(profile), block_(block), fault_(fault), at_(at), tcp_codes_(tcp_codes) {}

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

  bool refuse_code(char letter, double value, const CodeUse& use, std::size_t column) {
    const std::size_t length = at_ + 1 - column;
    const char* usual = letter == 'G' ? "E-GCODE" : "E-MCODE";
    if (use.refusal == 0)
      return refuse(fault_, column, length, usual,
                    fmt::format("{}{:g} is not understood for {}", letter, value, profile_.title),
                    "an unknown code may move the machine or change its state",
                    "post the program without it (abbe profiles lists the codes known)");
    const CodeRefusal& refusal = profile_.refusals[use.refusal - 1U];
    // what the profile calls it
    const char* code = refusal.error.empty() ? usual : refusal.error.c_str();
    return refuse(fault_, column, length, code, fmt::format("{}{:g} is refused", letter, value), refusal.why,
                  refusal.fix);
  }

  bool extra(char kind, const CodeUse& use, int code, std::size_t column) {
    if (block_.extra_count == Block::kMaxExtras)
      return refuse(fault_, column, at_ + 1 - column, "E-BLOCK", "too many codes in a block",
                    "no control accepts such a block", "use two blocks");
    const bool after = use.after || use.meaning == Meaning::exact_stop_once;
    block_.extras[static_cast<std::size_t>(block_.extra_count++)] = {kind, after, static_cast<std::int16_t>(code), use.words};
    return true;
  }

  bool g_word(double value, std::size_t column) {
    static constexpr CodeUse kUnknown{};
    int number = -1;
    const bool is_code = whole(value * 10, number) && number >= 0 && number < static_cast<int>(Profile::kGCodes);
    const bool switches = tcp_switch('G', number);
    static constexpr CodeUse kTcpLength{Meaning::tool_length, false, 0, 0, letters('H')};
    // G43.4 H applies the tool length as G43 does
    const CodeUse& use = switches && number == 434 ? kTcpLength : is_code ? profile_.g[static_cast<std::size_t>(number)] : kUnknown;
    if (switches && use.meaning == Meaning::unknown) return true;
    const Seat seat = seat_of(use.meaning);
    if (seat.group == kNoGroup) return extra('G', use, number, column);
    if (seat.group < 0) return refuse_code('G', value, use, column);
    const int code = use.meaning == Meaning::work_offset ? use.number - 1 : seat.code >= 0 ? seat.code : number;
    const auto group = static_cast<std::size_t>(seat.group);
    const std::uint32_t bit = std::uint32_t{1} << group;
    if ((block_.g_groups & bit) != 0) {
      // G80 may stand beside another motion code, which then counts alone.
      constexpr int no_motion = 800;
      if (code == no_motion) return true;
      if (block_.g[group] != no_motion)
        return refuse(fault_, column, at_ + 1 - column, "E-BLOCK",
                      fmt::format("G{:g}: two codes of one group in a block", value),
                      "they contradict each other", "use two blocks");
    }
    block_.g_groups |= bit;
    block_.g[group] = static_cast<std::int16_t>(code);
    block_.g_column[group] = static_cast<std::uint8_t>(column);
    block_.g_words[group] = use.words;
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
    static constexpr CodeUse kUnknown{};
    int number = -1;
    const bool is_code = whole(value, number) && number >= 0 && number < static_cast<int>(Profile::kMCodes);
    if (tcp_switch('M', 10 * number)) return true;
    const CodeUse& use = is_code ? profile_.m[static_cast<std::size_t>(number)] : kUnknown;
    const Seat seat = seat_of(use.meaning);
    if (seat.group == kNoGroup) return extra('M', use, number, column);
    if (seat.group < 0) return refuse_code('M', value, use, column);
    const auto group = static_cast<std::size_t>(seat.group);
    const std::uint32_t bit = std::uint32_t{1} << group;
    if ((block_.m_groups & bit) != 0)
      return refuse(fault_, column, at_ + 1 - column, "E-BLOCK",
                    fmt::format("M{:g}: two codes of one group in a block", value),
                    "their order is not defined", "use two blocks");
    block_.m_groups |= bit;
    block_.m[group] = static_cast<std::int16_t>(seat.code >= 0 ? seat.code : number);
    block_.m_column[group] = static_cast<std::uint8_t>(column);
    block_.m_words[group] = use.words;
    if (use.after) block_.m_after |= bit;
    return true;
  }

  bool value_word(char letter, double value, std::size_t column, bool first) {
    const std::size_t length = at_ + 1 - column;
    const Letters bit = letter_bit(letter);
    if (((kValueLetters | (profile_.letters & letter_bit('E'))) & bit) == 0) {
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
  const Profile& profile_;
  Block& block_;
  Fault& fault_;
  std::size_t at_;
  std::span<const TcpCode> tcp_codes_;
};

/// The words whose number stands without a point; zeros are the same either way.
Letters words_without_point(std::string_view line, const Block& block) {
  Letters found = 0;
  for (std::size_t i = 0; i < 26; ++i) {
    if ((block.words >> i & 1) == 0 || block.value[i] == 0) continue;
    std::size_t at = block.column[i];  // columns count from 1: this is behind the letter
    bool point = false;
    for (; at < line.size() && (is_blank(line[at]) || is_number_start(line[at])); ++at) point = point || line[at] == '.';
    if (!point) found |= Letters{1} << i;
  }
  return found;
}

/// Every control reads lines up to here.
constexpr std::size_t kEverywhere = 60;

/// What not every control allows of a line that was split into words.
bool read_rules(std::string_view line, const Profile& profile, Block& block, Fault& fault) {
  const bool words = block.words != 0 || block.g_groups != 0 || block.m_groups != 0;
  if (words && line.size() > profile.text.block_bytes)
    return refuse(fault, profile.text.block_bytes + 1, 1, "E-LINELEN",
                  fmt::format("the line has {} bytes, the control reads {}", line.size(), profile.text.block_bytes),
                  "the control stops at longer lines", "shorten the line");
  if (profile.numbers.integer_words != Profile::IntegerWords::units) block.pointless = words_without_point(line, block);
  return true;
}

}  // namespace

bool read_block(std::string_view line, const Profile& profile, Block& block, Fault& fault,
                std::span<const TcpCode> tcp_codes) {
  block.words = 0;
  block.g_groups = 0;
  block.m_groups = block.m_after = 0;
  block.extra_count = 0;
  block.pointless = 0;
  block.tcp_code = -1;
  block.deletable = false;
  block.comment_count = 0;
  if (line.size() > kMaxBlockLength)
    return refuse(fault, kMaxBlockLength + 1, 1, "E-LINELEN",
                  fmt::format("the line has {} bytes, the control reads {}", line.size(), kMaxBlockLength),
                  "controls stop at longer lines", "shorten the line");
  const char* const begin = line.data();
  const char* const behind = plain_words(begin, begin, begin + line.size(), block);
  const auto plain = static_cast<std::size_t>(behind - begin);
  if (plain != line.size() && !Scanner(line, plain, profile, block, fault, tcp_codes).scan()) return false;
  const bool usual = line.size() <= kEverywhere && profile.numbers.integer_words == Profile::IntegerWords::units;
  return usual || read_rules(line, profile, block, fault);
}

}  // namespace abbe::verifying
