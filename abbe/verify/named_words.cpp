// Lines of controls whose words have names, taken apart from left to right: a token is what belongs together
// in the control's eyes, and only then it is asked what it is.
#include "abbe/verify/named_words.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "abbe/core/number.h"
#include "abbe/verify/bracket_words.h"
#include "abbe/verify/word_taker.h"

namespace abbe::verifying {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::string_view kDigits = "0123456789";

bool is_capital_of(char c, char& capital) {
  capital = static_cast<char>(static_cast<unsigned char>(c) & 0xDFu);
  return capital >= 'A' && capital <= 'Z' && (c == capital || c == capital + ('a' - 'A'));
}

class NamedScanner : public WordTaker {
 public:
  using WordTaker::WordTaker;

  bool scan() {
    leave_blanks();
    if (rest().substr(0, 2) == "%_") return comment_to_end();
    if (!rest().empty() && rest()[0] == '/') {
      if (profile_.text.skip == Profile::Skip::none) return stray();
      block_.deletable = true;
      ++at_;
      if (!rest().empty() && kDigits.find(rest()[0]) != std::string_view::npos) ++at_;
    }
    for (leave_blanks(); !rest().empty(); leave_blanks()) {
      if (rest()[0] == ';') return comment_to_end();
      if (!token()) return false;
    }
    return true;
  }

 private:
  [[nodiscard]] std::string_view rest() const { return line_.substr(at_); }
  void leave_blanks() { at_ = std::min(line_.size(), line_.find_first_not_of(kBlanks, at_)); }
  [[nodiscard]] std::size_t behind_blanks(std::size_t at) const {
    return std::min(line_.size(), line_.find_first_not_of(kBlanks, at));
  }
  [[nodiscard]] char at(std::size_t place) const { return place < line_.size() ? line_[place] : '\n'; }

  bool comment_to_end() {
    block_.comments[static_cast<std::size_t>(block_.comment_count++)] = rest();
    at_ = line_.size();
    return true;
  }

  bool stray() {
    return refuse(fault_, at_ + 1, 1, "E-CHAR",
                  fmt::format("byte 0x{:02x} where a word begins", static_cast<unsigned char>(line_[at_])),
                  "its meaning is not known", "remove it or put it behind ;");
  }
  bool not_literal(std::size_t begin, std::size_t end) {
    return refuse(fault_, begin + 1, std::max<std::size_t>(1, end - begin), "E-EXPR",
                  "variables and expressions are not read", "their value is known only to the control",
                  "post the program with literal numbers");
  }

  /// One word with all that belongs to it.
  bool token() {
    const std::size_t begin = at_;
    std::string name;
    for (char capital = 0; at_ < line_.size(); ++at_) {
      const char c = line_[at_];
      if (is_capital_of(c, capital))
        name += capital;
      else if (c == '_' || (!name.empty() && kDigits.find(c) != std::string_view::npos))
        name += c;
      else
        break;
    }
    if (name.empty()) return stray();
    const bool alone_so_far = (block_.words & ~letter_bit('N')) == 0 && block_.g_groups == 0 &&
                              block_.m_groups == 0 && block_.extra_count == 0;
    if (name.size() > 1 && at(at_) == ':' && alone_so_far) {
      ++at_;
      block_.comments[static_cast<std::size_t>(block_.comment_count++)] = line_.substr(begin, at_ - begin);
      return true;
    }
    if (const Profile::Keyword* word = find_keyword(profile_, name)) return code_word(*word, begin);
    if (const std::size_t equals = behind_blanks(at_); at(equals) == '=')
      return assigned(name, begin, equals);
    const bool letter_and_number = name.size() == 1 || kDigits.find(name[1]) != std::string_view::npos;
    if (!letter_and_number)
      return refuse(fault_, begin + 1, name.size(), "E-GCODE",
                    fmt::format("{} is not understood for {}", name, profile_.title),
                    "an unknown word may move the machine or change its state",
                    "post the program without it");
    if (name[0] == 'R') return not_literal(begin, at_);  // R90 is a variable
    at_ = begin + 1;
    return number_word(name[0], begin);
  }

  /// X=IC(..) counts from where the axis stands, X=AC(..) and I=AC(..) from zero, whatever G90 and G91 say.
  bool stated_word(char letter, std::size_t begin) {
    char kind = 0, second = 0;
    const bool function = is_capital_of(at(at_), kind) && is_capital_of(at(at_ + 1), second);
    const std::size_t open = behind_blanks(at_ + 2);
    const bool axis = letter >= 'X';
    if (!function || second != 'C' || (kind != 'A' && !(axis && kind == 'I')) || at(open) != '(')
      return not_literal(begin, at_);
    at_ = open + 1;
    leave_blanks();
    const Decimal number = read_decimal(rest());
    const std::size_t close = behind_blanks(at_ + number.length);
    if (number.length == 0 || at(close) != ')' || !(std::abs(number.value) <= kMaxNumber))
      return not_literal(begin, close);
    at_ = close + 1;
    const bool first =
        block_.words == 0 && block_.g_groups == 0 && block_.m_groups == 0 && block_.extra_count == 0;
    const int bit = axis ? letter - 'X' : 3 + letter - 'I';
    (kind == 'I' ? block_.increments : block_.places) |= 1u << bit;
    return value_word(letter, number.value, begin + 1, first);
  }

  bool assigned(const std::string& name, std::size_t begin, std::size_t equals) {
    char letter = name[0];
    if (name.size() > 1)
      letter = find_address(profile_, name);
    else if (letter == 'R')
      letter = 0;  // a variable
    if (letter == 0 || at(equals + 1) == '=') return not_literal(begin, equals);
    at_ = equals + 1;
    leave_blanks();
    return number_word(letter, begin);
  }

  /// A literal number is at at_, or blanks and then the number.
  bool number_word(char letter, std::size_t begin) {
    leave_blanks();
    if (letter == 'T' && at(at_) == '"') {
      const std::size_t close = line_.find('"', at_ + 1);
      if (close == std::string_view::npos)
        return refuse(fault_, begin + 1, line_.size() - begin, "E-TOOL", "a tool's name that does not end",
                      "the tool is not known", "close it with '\"'");
      block_.tool_name = line_.substr(at_ + 1, close - at_ - 1);
      at_ = close + 1;
      return value_word('T', 0, begin + 1, false);
    }
    if (behind_turn_ && letter == 'Z') letter = 'R';  // ROT Z90 in G17: as ROT RPL=90
    const Decimal number = read_decimal(rest());
    const bool may_state = (letter >= 'X' && letter <= 'Z') || (letter >= 'I' && letter <= 'K');
    if (number.length == 0 && may_state) return stated_word(letter, begin);
    if (number.length == 0) return not_literal(begin, at_);
    at_ += number.length;
    char capital = 0;
    const char next = at(at_);
    if (at_ < line_.size() && !is_capital_of(next, capital) && next != '_' && next != ';' &&
        kBlanks.find(next) == std::string_view::npos)
      return not_literal(begin, at_);
    if (!(std::abs(number.value) <= kMaxNumber))
      return refuse(fault_, begin + 1, at_ - begin, "E-NUMBER", "the number is too large",
                    "no machine goes there", "correct the number");
    if (letter == 'G') return g_word(number.value, begin + 1);
    if (letter == 'M') return m_word(number.value, begin + 1);
    const bool first =
        block_.words == 0 && block_.g_groups == 0 && block_.m_groups == 0 && block_.extra_count == 0;
    return value_word(letter, number.value, begin + 1, first);
  }

  bool code_word(const Profile::Keyword& word, std::size_t begin) {
    using Form = Profile::Form;
    if (profile_.g[word.index].refusal != 0)
      return keyword(word, line_.substr(begin, at_ - begin), begin + 1);
    const std::size_t next = behind_blanks(at_);
    const char opens = at(next);
    bool known = true;
    if (word.form == Form::value) {
      std::size_t equals = next;
      if (opens == '[') equals = behind_blanks(std::min(line_.size(), line_.find(']', next)) + 1);
      const std::size_t digits = at(equals) == '=' ? behind_blanks(equals + 1) : line_.size();
      const std::size_t length = read_decimal(line_.substr(digits)).length;
      at_ = digits + length;
      char capital = 0;
      const char behind = at(at_);
      known = length > 0 && (at_ == line_.size() || is_capital_of(behind, capital) || behind == '_' ||
                             behind == ';' || kBlanks.find(behind) != std::string_view::npos);
    } else if (opens == '(') {
      const std::size_t close = closing(next);
      known =
          close != std::string_view::npos &&
          (word.form == Form::arguments || (word.form == Form::empty && behind_blanks(next + 1) == close));
      if (known) at_ = close + 1;
    } else {
      known = opens != '=' && opens != '[';
    }
    if (!known)
      return refuse(fault_, begin + 1, word.name.size(), "E-GCODE",
                    fmt::format("{} with something behind it that is not known", word.name),
                    "it may move the machine", "post the program without it");
    const Meaning meaning = profile_.g[word.index].meaning;
    behind_turn_ = meaning == Meaning::frame_turn || meaning == Meaning::frame_turn_further;
    std::string why;
    if (meaning == Meaning::bracket_cycle &&
        !take_brackets(line_.substr(begin, at_ - begin), block_.hole, why))
      return refuse(fault_, begin + 1, at_ - begin, "E-CYCLE", why, "where the cycle drills is not sure",
                    "write it with literal numbers");
    return keyword(word, line_.substr(begin, at_ - begin), begin + 1);
  }

  /// Where the bracket at `open` is closed; texts in quotes do not count.
  [[nodiscard]] std::size_t closing(std::size_t open) const {
    int open_brackets = 0;
    for (std::size_t i = open; i < line_.size(); ++i) {
      if (line_[i] == '"') {
        i = line_.find('"', i + 1);
        if (i == std::string_view::npos) return i;
      } else if (line_[i] == '(') {
        ++open_brackets;
      } else if (line_[i] == ')' && --open_brackets == 0) {
        return i;
      }
    }
    return std::string_view::npos;
  }

  bool behind_turn_ = false;
};

}  // namespace

bool read_named_words(std::string_view line, const Profile& profile, Block& block, Fault& fault,
                      std::span<const TcpCode> tcp_codes) {
  block.tool_name = {};
  if (line.size() > profile.text.block_bytes)
    return refuse(fault, profile.text.block_bytes + 1, 1, "E-LINELEN",
                  fmt::format("the line has {} bytes, {} are read", line.size(), profile.text.block_bytes),
                  "longer lines are not read", "shorten the line");
  return NamedScanner(line, 0, profile, block, fault, tcp_codes).scan();
}

}  // namespace abbe::verifying
