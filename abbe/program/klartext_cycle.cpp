#include "abbe/program/klartext_cycle.h"

#include <fmt/format.h>

#include <string>

#include "abbe/program/hole_cycle.h"

namespace abbe {
namespace {

bool makes_datum_frame(Meaning meaning) {
  return meaning == Meaning::datum_turn || meaning == Meaning::datum_mirror ||
         meaning == Meaning::datum_scale || meaning == Meaning::datum_scale_evenly;
}

}  // namespace

// "CYCL DEF 7.1 X+5", "CYCL DEF 247 DATUM SETTING ~".
std::optional<BlockError> KlartextCycle::read_definition(std::size_t begin) {
  skip_blanks();
  std::string cycle = "CYCL";
  while (at_ < end_ && is_digit(text_[at_])) cycle += text_[at_++];
  int part = -1;
  if (at_ + 1 < end_ && text_[at_] == '.' && is_digit(text_[at_ + 1])) {
    part = text_[at_ + 1] - '0';
    at_ += 2;
    if (at_ < end_ && is_digit(text_[at_])) return strange(begin, at_ - begin);
  }
  const Profile::Keyword* keyword = find_keyword(profile_, cycle);
  const bool ends = at_ == end_ || is_blank(text_[at_]);
  if (keyword == nullptr || !ends)
    return wrong("E-CYCLE", begin, fmt::format("{} is not known to the {} profile", cycle, profile_.title),
                 "a cycle that is not understood may move the machine or change a frame", "post without it");
  const Meaning meaning = profile_.g[keyword->index].meaning;
  if (meaning == Meaning::unknown) {
    if (part <= 0) return refused(*keyword, begin, at_ - begin);
    return copied();  // its first line was refused
  }
  if (meaning == Meaning::hole_cycle)
    return part < 0 ? begin_hole(*keyword, begin) : read_hole_part(*keyword, part, begin);
  if (part == 0) return copied();  // the title of the parts that follow
  if (meaning == Meaning::copy || meaning == Meaning::smoothing) {
    at_ = end_;
    return add_code(*keyword, begin, end_);
  }
  if (meaning == Meaning::numbered_work_offset) {
    context_.definition = keyword;
    context_.wanting = true;
    while (at_ < end_ && text_[at_] != 'Q') ++at_;
    return read_parameters();
  }
  if (makes_datum_frame(meaning) && part == 1) return read_frame(*keyword, begin);
  return read_shift(*keyword, begin);
}

// "ROT+35", "X Y", "X1.4 Y0.6 CCX+15 CCY+20", "SCL0.995".
std::optional<BlockError> KlartextCycle::read_frame(const Profile::Keyword& keyword, std::size_t begin) {
  if (auto error = add_code(keyword, begin, at_)) return error;
  const Meaning meaning = profile_.g[keyword.index].meaning;
  for (skip_blanks(); at_ < end_; skip_blanks()) {
    bool known = false;
    if (auto error = read_frame_word(meaning, known)) return error;
    if (!known)
      return wrong(
          "E-FRAME", begin, fmt::format("{} in a form that is not followed", keyword.name),
          "the frame of what follows is not known",
          "write 10.1 ROT+.., 8.1 with X, Y or nothing, 26.1 with X, Y, Z and CCX, CCY, or 11.1 SCL..");
  }
  const bool bare = block_.count == 1 && meaning != Meaning::datum_mirror;
  if (!bare) return std::nullopt;
  return wrong("E-FRAME", begin, fmt::format("{} without its value", keyword.name),
               "the frame of what follows is not known", "write the value");
}

// One word of such a block. `known` becomes true where it belongs to it.
std::optional<BlockError> KlartextCycle::read_frame_word(Meaning meaning, bool& known) {
  const std::size_t begin = at_;
  const std::string_view said = name();
  const bool axis = said.size() == 1 && said[0] >= 'X' && said[0] <= 'Z';
  const bool centre = said.size() == 3 && said.substr(0, 2) == "CC" && said[2] >= 'X' && said[2] <= 'Z';
  switch (meaning) {
    case Meaning::datum_turn:
      known = said == "ROT" && block_.count == 1;
      return known ? read_value('R', begin) : std::nullopt;
    case Meaning::datum_mirror:
      known = axis && said[0] != 'Z' && (at_ == end_ || is_blank(text_[at_]));
      return known ? add(said[0], begin, at_, at_, 0) : std::nullopt;
    case Meaning::datum_scale:
      known = axis || centre;
      if (!known) return std::nullopt;
      return read_value(axis ? said[0] : static_cast<char>('I' + (said[2] - 'X')), begin);
    default:
      known = said == "SCL" && block_.count == 1;
      return known ? read_value('P', begin) : std::nullopt;
  }
}

std::optional<BlockError> KlartextCycle::read_cycle_words() {
  block_.cycle = static_cast<std::int16_t>(context_.cycle);
  return read_hole_words(context_.cycle, at_, end_, context_.comma, block_);
}

// "CYCL DEF 200 DRILLING ~", perhaps with its first Q words.
std::optional<BlockError> KlartextCycle::begin_hole(const Profile::Keyword& keyword, std::size_t begin) {
  const int cycle = hole_cycle_number(keyword.name);
  if (cycle == 0 || has_parts(cycle)) return refused(keyword, begin, at_ - begin);
  context_.cycle = cycle;
  context_.definition = &keyword;
  block_.defines = true;
  const auto word_begins = [&] {
    return text_[at_] == 'Q' && is_blank(text_[at_ - 1]) && at_ + 1 < end_ && is_digit(text_[at_ + 1]);
  };
  while (at_ < end_ && !word_begins()) ++at_;
  block_.words_end = static_cast<std::uint16_t>(at_);
  return read_cycle_words();
}

// "CYCL DEF 1.0 PECKING", then "CYCL DEF 1.1 SET UP 2" and so on.
std::optional<BlockError> KlartextCycle::read_hole_part(const Profile::Keyword& keyword, int part,
                                                        std::size_t begin) {
  const int cycle = hole_cycle_number(keyword.name);
  if (!has_parts(cycle)) return refused(keyword, begin, at_ - begin);
  block_.cycle = static_cast<std::int16_t>(cycle);
  block_.words_end = static_cast<std::uint16_t>(end_);
  block_.defines = part == 0;
  return block_.defines ? copied() : read_hole_value(cycle, part, at_, end_, context_.comma, block_);
}

std::optional<BlockError> KlartextCycle::read_shift(const Profile::Keyword& keyword, std::size_t begin) {
  if (auto error = add_code(keyword, begin, at_)) return error;
  if (auto error = read_coordinates()) return error;
  if (profile_.g[keyword.index].meaning == Meaning::local_shift && block_.count == 2 && at_ == end_ &&
      block_.increments == 0 && block_.words[1].letter >= 'X')
    return std::nullopt;
  return wrong("E-FRAME", begin, "a cycle of frames in a form that is not known",
               "a row of the datum table, an increment, a title without its lines: the frame is not known",
               "write CYCL DEF 7.1 X+10 and so on: the shift of one axis in each line, in numbers");
}

std::optional<BlockError> KlartextCycle::read_parameters() {
  constexpr std::string_view kPreset = "Q339";
  if (at_ == end_) {
    if (context_.open || !context_.wanting) return std::nullopt;
    return wrong("E-WCS", 0, "CYCL DEF 247 without Q339", "the preset that it puts in force is not known",
                 "write Q339=+1");
  }
  context_.wanting = false;
  const std::size_t begin = at_;
  std::size_t at = at_ + 1;
  while (at < end_ && is_digit(text_[at])) ++at;
  const std::string_view parameter = text_.substr(begin, at - begin);
  at_ = at;
  skip_blanks();
  const bool assigned = at_ < end_ && text_[at_] == '=';
  if (parameter != kPreset || !assigned)
    return wrong("E-WCS", begin, "a parameter of CYCL DEF 247 that is not Q339=..", "the frame is not known",
                 "write Q339=+1");
  ++at_;
  if (auto error = add_code(*context_.definition, begin, at)) return error;
  if (auto error = read_value('P', begin)) return error;
  skip_blanks();
  if (at_ == end_) return std::nullopt;
  return strange(at_, 0);
}

}  // namespace abbe
