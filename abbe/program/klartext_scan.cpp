#include "abbe/program/klartext_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "abbe/program/klartext_number.h"

namespace abbe {
namespace {

BlockError not_literal(std::size_t at, std::size_t length, std::string_view said) {
  return {"E-EXPR",
          at,
          std::max<std::size_t>(1, length),
          fmt::format("{}: not a literal number", said),
          "where the axes go depends on values that only the control knows when the program runs",
          "post the program with literal numbers (Q parameters resolved)"};
}

}  // namespace

// What stands behind ';' is a comment, a '~' at the end says that the block goes on.
void KlartextScan::take_tail() {
  end_ = text_.size();
  while (end_ > 0 && is_blank(text_[end_ - 1])) --end_;
  context_.open = end_ > 0 && text_[end_ - 1] == '~';
  if (context_.open) --end_;
  const std::size_t comment = text_.substr(0, end_).find(';');
  if (comment != std::string_view::npos) {
    block_.has_comment = true;
    end_ = comment;
  }
  while (end_ > 0 && is_blank(text_[end_ - 1])) --end_;
}

void KlartextScan::skip_blanks() {
  while (at_ < end_ && is_blank(text_[at_])) ++at_;
}

std::string_view KlartextScan::name() {
  const std::size_t begin = at_;
  while (at_ < end_ && is_letter(text_[at_])) ++at_;
  return text_.substr(begin, at_ - begin);
}

std::optional<BlockError> KlartextScan::copied() {
  block_.has_comment = true;
  at_ = end_;
  return std::nullopt;
}

// What stands in the block from at_ on, its blanks made one.
std::string KlartextScan::rest() const {
  std::string said;
  for (std::size_t i = at_; i < end_; ++i) {
    if (!is_blank(text_[i]))
      said += text_[i];
    else if (!said.empty() && said.back() != ' ')
      said += ' ';
  }
  return said;
}

/// The word at `begin` is not one of ours: what the profile says of it.
BlockError KlartextScan::strange(std::size_t begin, std::size_t length) const {
  const std::string_view said = text_.substr(begin, std::max<std::size_t>(1, length));
  const bool variable = (length == 1 && said[0] == 'Q') || (length == 2 && said[1] == 'Q');  // Q5, FQ5
  if (variable) return not_literal(begin, length, said);
  if (const Profile::Keyword* keyword = find_keyword(profile_, said)) return refused(*keyword, begin, length);
  if (length == 0) {
    const auto byte = static_cast<unsigned char>(said[0]);
    return {"E-CHAR",
            begin,
            1,
            fmt::format("byte 0x{:02X} where a word should begin", byte),
            "what the block does is not known",
            "remove it, or put it behind ';'"};
  }
  return {"E-GCODE",
          begin,
          length,
          fmt::format("{} is not known to the {} profile", said, profile_.title),
          "a word that is not understood may move the machine or change a frame",
          "remove it, or post without it"};
}

BlockError KlartextScan::refused(const Profile::Keyword& keyword, std::size_t begin,
                                 std::size_t length) const {
  const CodeUse& use = profile_.g[keyword.index];
  if (use.refusal == 0) {
    return {"E-GCODE",
            begin,
            length,
            fmt::format("{} in a form that is not known", keyword.name),
            "what it does depends on what stands with it",
            "remove it, or post without it"};
  }
  const CodeRefusal& refusal = profile_.refusals[use.refusal - 1U];
  return {refusal.error.empty() ? "E-GCODE" : refusal.error.c_str(), begin,       length,
          fmt::format("{} cannot be compensated", keyword.name),     refusal.why, refusal.fix};
}

BlockError KlartextScan::wrong(const char* code, std::size_t begin, std::string message, const char* why,
                               const char* fix) const {
  return {code, begin, std::max<std::size_t>(1, end_ - std::min(end_, begin)), std::move(message), why, fix};
}

std::optional<BlockError> KlartextScan::add(char letter, std::size_t begin, std::size_t number,
                                            std::size_t end, double value, int decimals) {
  if (block_.count == Block::kMaxWords)
    return wrong("E-BLOCK", begin, fmt::format("more than {} words in one block", Block::kMaxWords),
                 "no control accepts such a block", "break the block into several");
  block_.words[static_cast<std::size_t>(block_.count++)] = {letter,
                                                            true,
                                                            static_cast<std::uint16_t>(begin),
                                                            static_cast<std::uint16_t>(number),
                                                            static_cast<std::uint16_t>(end),
                                                            static_cast<std::uint16_t>(decimals),
                                                            value};
  return std::nullopt;
}

std::optional<BlockError> KlartextScan::add_code(const Profile::Keyword& keyword, std::size_t begin,
                                                 std::size_t end) {
  return add('G', begin, begin, end, static_cast<double>(keyword.index) / 10);
}

// "+10.5", "-0,25": the comma counts as a point. The number begins at or behind at_.
std::optional<BlockError> KlartextScan::read_value(char letter, std::size_t begin) {
  skip_blanks();
  const KlartextNumber number = read_klartext_number(text_.substr(at_, end_ - at_));
  if (number.length == 0) {
    const std::size_t n = std::min(end_ - at_, text_.substr(at_).find_first_not_of("0123456789.,+-"));
    return not_literal(begin, at_ + n + 1 - begin, text_.substr(begin, std::min(end_, at_ + n + 1) - begin));
  }
  block_.style.comma = context_.comma = context_.comma || number.comma;
  const std::size_t from = at_;
  at_ += number.length;
  return add(letter, begin, from, at_, number.value, number.decimals);
}

// X Y Z A B C, with I before X Y Z. False: something else stands here.
bool KlartextScan::read_coordinate(std::optional<BlockError>& error) {
  const std::size_t begin = at_;
  const bool increment = at_ + 1 < end_ && text_[at_] == 'I';
  const char letter = at_ < end_ ? text_[increment ? at_ + 1 : at_] : '\0';
  const bool linear = letter >= 'X' && letter <= 'Z', turns = letter >= 'A' && letter <= 'C';
  const std::size_t behind = begin + (increment ? 2 : 1);
  if ((!linear && !turns) || (behind < end_ && is_letter(text_[behind]))) return false;
  at_ = behind;
  if (increment && turns) {
    error = wrong("E-ROTARY", begin, "an increment of a rotary axis",
                  "how it adds up with corrections and whole turns is not sure", "post the angle itself");
    return true;
  }
  if (increment) block_.increments = static_cast<std::uint8_t>(block_.increments | 1U << (letter - 'X'));
  error = read_value(letter, begin);
  block_.words_end = static_cast<std::uint16_t>(at_);
  return true;
}

std::optional<BlockError> KlartextScan::read_coordinates() {
  for (skip_blanks(); at_ < end_; skip_blanks()) {
    std::optional<BlockError> error;
    if (!read_coordinate(error)) break;
    if (error) return error;
  }
  return std::nullopt;
}

}  // namespace abbe
