#include "abbe/program/named_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "abbe/core/number.h"
#include "abbe/program/bracket_cycle.h"

namespace abbe {
namespace {

constexpr bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
constexpr int kCentres = 3;  // of Block::places: I J K
constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr char capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }
constexpr bool is_letter(char c) { return capital(c) >= 'A' && capital(c) <= 'Z'; }
constexpr bool is_name(char c) { return is_letter(c) || is_digit(c) || c == '_'; }
constexpr bool begins_number(char c) { return is_digit(c) || c == '.' || c == '+' || c == '-'; }
/// What may stand behind a number: the next word, a comment, nothing.
constexpr bool may_follow_number(char c) { return is_blank(c) || is_letter(c) || c == '_' || c == ';'; }

/// One line on its way to a Block.
class NamedLine {
 public:
  NamedLine(const Profile& profile, Block& block) : profile_(profile), block_(block), text_(block.text) {}

  std::optional<BlockError> read() {
    skip_blanks();
    if (at_ + 1 < text_.size() && text_[at_] == '%' && text_[at_ + 1] == '_') {  // name in an archive
      block_.has_comment = true;
      return std::nullopt;
    }
    if (at_ < text_.size() && text_[at_] == '/') read_slash();
    while (skip_blanks(), at_ < text_.size()) {
      if (text_[at_] == ';') {
        block_.has_comment = block_.has_semicolon = true;
        return std::nullopt;
      }
      if (auto error = is_letter(text_[at_]) || text_[at_] == '_' ? read_word() : std::optional(strange()))
        return error;
    }
    return std::nullopt;
  }

 private:
  void skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  }
  [[nodiscard]] char next_after_blanks(std::size_t at) const {
    while (at < text_.size() && is_blank(text_[at])) ++at;
    return at < text_.size() ? text_[at] : '\0';
  }

  void read_slash() {
    block_.slash = true;
    block_.slash_begin = static_cast<std::uint16_t>(at_++);
    if (at_ < text_.size() && is_digit(text_[at_])) ++at_;
    block_.slash_end = block_.words_end = static_cast<std::uint16_t>(at_);
  }

  [[nodiscard]] BlockError strange() const {
    const auto byte = static_cast<unsigned char>(text_[at_]);
    const std::string what =
        byte >= 0x20 && byte < 0x7f ? fmt::format("'{}'", text_[at_]) : fmt::format("byte 0x{:02X}", byte);
    return {"E-CHAR",
            at_,
            1,
            what + " where a word should begin",
            "what the block does is not known",
            "remove it, or put it behind ';'"};
  }
  [[nodiscard]] static BlockError expression(std::size_t at, std::size_t length, std::string_view name) {
    return {"E-EXPR",
            at,
            length,
            fmt::format("{}: not a literal number", name),
            "where the axes go depends on values that only the control knows when the program runs",
            "post the program with literal coordinates (variables resolved)"};
  }

  std::optional<BlockError> read_word() {
    const std::size_t begin = at_;
    std::size_t end = begin;
    std::string name;
    while (end < text_.size() && is_name(text_[end])) name += capital(text_[end++]);
    const char next = next_after_blanks(end);
    const bool first = block_.count == 0 || (block_.count == 1 && block_.words[0].letter == 'N');
    const bool plain = name.size() == 1 || is_digit(name[1]);
    if (next == ':' && first && name.size() > 1 && text_[end] == ':') {  // a label: nobody jumps to it
      block_.has_comment = true;
      at_ = end + 1;
      return std::nullopt;
    }
    if (const Profile::Keyword* keyword = find_keyword(profile_, name))
      return read_keyword(*keyword, begin, end);
    if (next == '=') return read_assignment(name, begin, end);
    if (!plain) {
      return BlockError{"E-GCODE",
                        begin,
                        end - begin,
                        fmt::format("{} is not known to the {} profile", name, profile_.title),
                        "a word that is not understood may move the machine or change a frame",
                        "remove it, or post without it"};
    }
    if (name[0] == 'R') return expression(begin, end - begin, name);  // a variable: radii are CR=, turns RPL=
    return read_letter(name[0], begin, begin + 1);
  }

  /// "IC(5)" of X Y Z, "AC(5)" also of I J K: this word alone is a distance, or a place. nullopt: neither.
  [[nodiscard]] std::optional<bool> states_distance(char letter, std::size_t at) const {
    const bool axis = letter >= 'X' && letter <= 'Z', centre = letter >= 'I' && letter <= 'K';
    const bool known = (axis || centre) && at + 2 < text_.size() && capital(text_[at + 1]) == 'C';
    if (!known || next_after_blanks(at + 2) != '(') return std::nullopt;
    const char kind = capital(text_[at]);
    if (kind == 'A') return false;
    return axis && kind == 'I' ? std::optional(true) : std::nullopt;
  }
  std::optional<BlockError> read_stated(char letter, bool distance, std::size_t begin, std::size_t at) {
    std::size_t number_at = text_.find('(', at) + 1;
    while (number_at < text_.size() && is_blank(text_[number_at])) ++number_at;
    const Decimal number = read_decimal(text_.substr(number_at));
    const std::size_t end = number_at + number.length;
    if (number.length == 0 || next_after_blanks(end) != ')')
      return expression(begin, std::min(end + 1, text_.size()) - begin, text_.substr(begin, end - begin));
    auto error = add(letter, begin, number_at, end, number.value, number.decimals);
    auto& axes = distance ? block_.increments : block_.places;
    const int bit = letter >= 'X' ? letter - 'X' : kCentres + letter - 'I';
    axes = static_cast<std::uint8_t>(axes | 1u << bit);
    at_ = text_.find(')', end) + 1;
    block_.words_end = static_cast<std::uint16_t>(at_);
    return error;
  }

  /// "X10.5", or what follows "X=": the number begins at or behind `at`.
  std::optional<BlockError> read_letter(char letter, std::size_t begin, std::size_t at) {
    if (letter == 'Z' && turns_) letter = 'R';  // in G17 a turn about Z is one in the plane: RPL
    while (at < text_.size() && is_blank(text_[at])) ++at;
    if (const auto distance = states_distance(letter, at)) return read_stated(letter, *distance, begin, at);
    if (letter == 'T' && at < text_.size() && text_[at] == '"') return read_tool_name(begin, at);
    const Decimal number = read_decimal(text_.substr(at));
    if (number.length == 0 || !begins_number(text_[at])) {
      return BlockError{
          "E-EXPR",
          begin,
          std::max<std::size_t>(1, at - begin),
          fmt::format("{} is not followed by a literal number", letter),
          "where the axes go depends on values that only the control knows when the program runs",
          "post the program with literal numbers"};
    }
    const std::size_t end = at + number.length;
    if (end < text_.size() && !may_follow_number(text_[end]))
      return expression(begin, end + 1 - begin, text_.substr(begin, end + 1 - begin));
    constexpr double kNoCode = -1;  // beyond the numbers of codes: not known
    const bool beyond = letter == 'G' && number.value >= static_cast<double>(Profile::kGCodes) / 10;
    return add(letter, begin, at, end, beyond ? kNoCode : number.value, number.decimals);
  }

  // T="DRILL 8.5": which tool that is, the tool table says.
  std::optional<BlockError> read_tool_name(std::size_t begin, std::size_t quote) {
    const std::size_t close = text_.find('"', quote + 1);
    if (close != std::string_view::npos) return add('T', begin, quote, close + 1, 0, 0);
    return BlockError{
        "E-TOOL",  begin, text_.size() - begin, "the name of the tool has no end", "the tool is not known",
        "add '\"'"};
  }

  std::optional<BlockError> read_assignment(const std::string& name, std::size_t begin, std::size_t end) {
    const std::size_t equals = text_.find('=', end);
    const bool comparison = equals + 1 < text_.size() && text_[equals + 1] == '=';
    // "R=" is no word of the control: a radius is CR=
    const char letter = name.size() > 1 ? find_address(profile_, name) : name[0] == 'R' ? '\0' : name[0];
    if (letter == 0 || comparison) return expression(begin, end - begin, name);
    return read_letter(letter, begin, equals + 1);
  }

  std::optional<BlockError> read_keyword(const Profile::Keyword& keyword, std::size_t begin,
                                         std::size_t end) {
    const CodeUse& use = profile_.g[keyword.index];
    if (use.refusal != 0) {
      const CodeRefusal& refusal = profile_.refusals[use.refusal - 1U];
      return BlockError{refusal.error.empty() ? "E-GCODE" : refusal.error.c_str(), begin,       end - begin,
                        fmt::format("{} cannot be compensated", keyword.name),     refusal.why, refusal.fix};
    }
    using Form = Profile::Form;
    std::size_t last = end;
    const char next = next_after_blanks(end);
    bool good = next != '(' || keyword.form == Form::arguments || keyword.form == Form::empty;
    if (keyword.form == Form::value)
      good = behind_value(end, last);
    else if (good && next == '(')
      good = behind_brackets(text_.find('(', end), last) &&
             (keyword.form == Form::arguments || all_blank(text_.find('(', end) + 1, last - 1));
    else
      good = good && next != '=' && next != '[';
    if (!good) {
      return BlockError{"E-GCODE",
                        begin,
                        end - begin,
                        fmt::format("{} in a form that is not known", keyword.name),
                        "what it does depends on what follows it",
                        "remove it, or post without it"};
    }
    turns_ = use.meaning == Meaning::frame_turn || use.meaning == Meaning::frame_turn_further;
    if (use.meaning == Meaning::modal_call) block_.modal_call = true;
    if (use.meaning == Meaning::bracket_cycle) {
      block_.cycle = static_cast<std::int16_t>(bracket_cycle_number(keyword.name));
      block_.brackets = text_.substr(begin, last - begin);
    }
    return add('G', begin, begin, last, static_cast<double>(keyword.index) / 10, 0);
  }

  [[nodiscard]] bool all_blank(std::size_t from, std::size_t to) const {
    return std::all_of(text_.begin() + static_cast<std::ptrdiff_t>(from),
                       text_.begin() + static_cast<std::ptrdiff_t>(to), is_blank);
  }
  // "(..)" with brackets and quoted text inside.
  [[nodiscard]] bool behind_brackets(std::size_t open, std::size_t& last) const {
    int depth = 0;
    bool quoted = false;
    for (std::size_t at = open; at < text_.size(); ++at) {
      const char c = text_[at];
      if (c == '"') quoted = !quoted;
      if (quoted) continue;
      depth += c == '(' ? 1 : c == ')' ? -1 : 0;
      if (depth == 0) {
        last = at + 1;
        return true;
      }
    }
    return false;
  }
  // "=0.01", "[A]=10".
  [[nodiscard]] bool behind_value(std::size_t end, std::size_t& last) const {
    std::size_t at = end;
    while (at < text_.size() && is_blank(text_[at])) ++at;
    if (at < text_.size() && text_[at] == '[') {
      const std::size_t close = text_.find(']', at);
      if (close == std::string_view::npos) return false;
      at = close + 1;
    }
    while (at < text_.size() && is_blank(text_[at])) ++at;
    if (at >= text_.size() || text_[at] != '=') return false;
    ++at;
    while (at < text_.size() && is_blank(text_[at])) ++at;
    const Decimal number = read_decimal(text_.substr(at));
    last = at + number.length;
    return number.length > 0 && (last == text_.size() || may_follow_number(text_[last]));
  }

  std::optional<BlockError> add(char letter, std::size_t begin, std::size_t number, std::size_t end,
                                double value, int decimals) {
    if (block_.count == Block::kMaxWords) {
      return BlockError{"E-BLOCK",
                        begin,
                        1,
                        fmt::format("more than {} words in one block", Block::kMaxWords),
                        "no control accepts such a block",
                        "break the block into several"};
    }
    Word& word = block_.words[static_cast<std::size_t>(block_.count++)];
    word = {letter,
            true,
            static_cast<std::uint16_t>(begin),
            static_cast<std::uint16_t>(number),
            static_cast<std::uint16_t>(end),
            static_cast<std::uint16_t>(decimals),
            value};
    block_.words_end = word.end;
    at_ = end;
    return std::nullopt;
  }

  const Profile& profile_;
  Block& block_;
  std::string_view text_;
  std::size_t at_ = 0;
  bool turns_ = false;  ///< behind ROT or AROT
};

}  // namespace

std::optional<BlockError> read_named_block(std::string_view line, const Profile& profile, Block& block) {
  block.cycle = 0;
  block.modal_call = false;
  if (auto error = begin_block(line, block)) return error;
  return NamedLine(profile, block).read();
}

}  // namespace abbe
