#include "abbe/program/klartext_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "abbe/program/klartext_cycle.h"
#include "abbe/program/klartext_number.h"

namespace abbe {
namespace {

constexpr std::size_t kMostDigitsOfBlock = 9;

// Codes as the readers number them.
constexpr double kRapid = 0, kLine = 1, kClockwise = 2, kCounterClockwise = 3, kInch = 20, kMm = 21,
                 kMachinePlace = 28, kNoRadius = 40, kLeft = 41, kRight = 42, kLength = 43, kNoLength = 49,
                 kCallCycle = 99, kTipControl = 128, kNoTipControl = 129;

/// One line on its way to a Block.
class KlartextLine : public KlartextCycle {
 public:
  using KlartextCycle::KlartextCycle;

  std::optional<BlockError> read() {
    const bool continued = context_.open;
    take_tail();
    skip_blanks();
    if (continued) return read_continued();
    const bool parameter = at_ + 1 < end_ && text_[at_] == 'Q' && is_digit(text_[at_ + 1]);
    if (context_.cycle != 0 && parameter) return read_cycle_words();
    context_.definition = nullptr;
    context_.cycle = 0;
    if (auto error = read_first_line()) return error;
    if (!context_.open || may_go_on_ || context_.definition != nullptr) return std::nullopt;
    return wrong(
        "E-BLOCK", 0, "a block that goes on in the next line",
        "only comments, BLK FORM, cycle 247 and drilling cycles are followed there: its other words would "
        "be lost",
        "write the block in one line, without '~'");
  }

 private:
  std::optional<BlockError> read_first_line() {
    if (const auto number = read_block_number(text_)) at_ = number->end;
    skip_blanks();
    may_go_on_ = block_.has_comment;
    if (at_ == end_) return std::nullopt;
    if (text_[at_] == '*') {  // "* - heading"
      block_.has_comment = may_go_on_ = true;
      return std::nullopt;
    }
    const std::size_t begin = at_;
    const std::string_view first = name();
    block_.words_end = static_cast<std::uint16_t>(at_);
    may_go_on_ = first == "BLK";
    if (first == "L") return read_line_block(begin);
    if (first == "C" || first == "CR") return read_arc(begin, first == "C");
    if (first == "CC") return read_pole();
    if (first == "TOOL") return read_tool(begin);
    if (first == "CYCL" || first == "CYCLE") return read_cycle(begin);
    if (first == "BEGIN" || first == "END") return read_frame_of_program(begin, first == "BEGIN");
    if (first == "BLK") return copied();
    if (first == "LBL") return read_label(begin, false);
    if (first == "CALL") return read_call(begin);
    if (first == "PLANE") return read_plane(begin);
    if (first == "FUNCTION") return read_tip_control(begin);
    if (first == "STOP") {
      add('M', begin, begin, at_, 0);
      return read_others();
    }
    at_ = begin;
    if (first == "M") return read_others();
    return strange(begin, first.size());
  }

  // A line behind '~': a parameter of the cycle that is defined, or more of a comment.
  std::optional<BlockError> read_continued() {
    if (context_.definition == nullptr) return copied();
    return context_.cycle != 0 ? read_cycle_words() : read_parameters();
  }
  // The label behind LBL: a number or a name in quotes, and nothing else.
  std::optional<BlockError> read_label(std::size_t begin, bool called) {
    skip_blanks();
    const std::string_view label = text_.substr(at_, end_ - at_);
    const bool number = !label.empty() && label.find_first_not_of("0123456789") == std::string_view::npos;
    const bool name = label.size() > 2 && label.front() == '"' && label.find('"', 1) == label.size() - 1;
    if (!number && !name)
      return wrong("E-OWORD", begin, "a label, or a call, in a form that is not known",
                   "repeats and jumps need other corrections each time",
                   "post them expanded: the blocks in place of each call");
    const bool ends = number && label.find_first_not_of('0') == std::string_view::npos;
    if (ends && called) return strange(begin, 4);
    block_.flow = called ? Block::Flow::call : ends ? Block::Flow::end : Block::Flow::label;
    block_.label = label;
    return copied();
  }
  std::optional<BlockError> read_call(std::size_t begin) {
    skip_blanks();
    if (name() != "LBL") return strange(begin, 4);
    return read_label(begin, true);
  }

  // FUNCTION TCPM, with the words that make it M128, and its end.
  std::optional<BlockError> read_tip_control(std::size_t begin) {
    const std::string said = rest();
    const bool on = said == "TCPM F TCP AXIS POS PATHCTRL AXIS" ||
                    said == "TCPM F TCP AXIS POS PATHCTRL AXIS REFPNT TIP-TIP";
    if (!on && said != "RESET TCPM") return strange(begin, 8);
    at_ = end_;
    return add('M', begin, begin, end_, on ? kTipControl : kNoTipControl);
  }
  // L: rapid if FMAX stands behind it.
  std::optional<BlockError> read_line_block(std::size_t begin) {
    if (auto error = add('G', begin, begin, at_, kLine)) return error;
    if (auto error = read_coordinates()) return error;
    return read_others();
  }
  std::optional<BlockError> read_arc(std::size_t begin, bool about_pole) {
    if (auto error = add('G', begin, begin, at_, 0)) return error;
    block_.pole = about_pole ? Block::Pole::used : Block::Pole::none;
    if (auto error = read_coordinates()) return error;
    if (!about_pole) {
      const std::size_t radius = at_;
      if (at_ >= end_ || text_[at_] != 'R')
        return wrong("E-ARC", begin, "CR without R", "the path is not defined", "add the radius");
      ++at_;
      if (auto error = read_value('R', radius)) return error;
      skip_blanks();
    }
    const std::size_t turn = at_;
    const bool stands = text_.substr(at_, 2) == "DR" && at_ + 2 < end_ &&
                        (text_[at_ + 2] == '+' || text_[at_ + 2] == '-') &&
                        (at_ + 3 == end_ || is_blank(text_[at_ + 3]));
    const Profile::Keyword* keyword = stands ? find_keyword(profile_, "DR") : nullptr;
    if (keyword == nullptr)
      return wrong("E-ARC", begin, "an arc without DR+ or DR- behind its end",
                   "which way round it goes depends on the block before", "add it");
    block_.words[0].value = text_[at_ + 2] == '-' ? kClockwise : kCounterClockwise;
    at_ += 3;
    if (auto error = add_code(*keyword, turn, at_)) return error;
    return read_others();
  }

  std::optional<BlockError> read_pole() {
    block_.pole = Block::Pole::set;
    if (auto error = read_coordinates()) return error;
    const bool both = block_.count == 2 && block_.words[0].letter == 'X' && block_.words[1].letter == 'Y';
    if (!both || block_.increments != 0 || at_ < end_)
      return wrong("E-ARC", 0, "a pole that is not CC X.. Y..",
                   "where it is depends on the blocks before, or it lies in another plane",
                   "post CC with X and Y as places, and nothing else");
    block_.words[0].letter = 'I';
    block_.words[1].letter = 'J';
    return std::nullopt;
  }

  // R0, RL, RR, F, M and nothing else, up to the end.
  std::optional<BlockError> read_others() {
    for (skip_blanks(); at_ < end_; skip_blanks()) {
      const std::size_t begin = at_;
      const std::string_view word = name();
      std::optional<BlockError> error;
      if (word == "F" || word == "FMAX") {
        error = read_feed(begin, word.size() > 1);
      } else if (word == "M") {
        error = read_function(begin);
      } else if (word == "R" && at_ < end_ && text_[at_] == '0' &&
                 (at_ + 1 == end_ || is_blank(text_[at_ + 1]))) {
        error = add('G', begin, begin, ++at_, kNoRadius);
      } else if ((word == "RL" || word == "RR") && (at_ == end_ || is_blank(text_[at_]))) {
        error = add('G', begin, begin, at_, word == "RL" ? kLeft : kRight);
      } else if (word == "S") {
        error = read_value('S', begin);
      } else {
        error = strange(begin, word.size());
      }
      if (error) return error;
    }
    return std::nullopt;
  }
  std::optional<BlockError> read_function(std::size_t begin) {
    constexpr double kMachinePlaces = 91, kFewerPoints = 124, kRetract = 140;
    if (auto error = read_value('M', begin)) return error;
    Word& code = block_.words[static_cast<std::size_t>(block_.count) - 1];
    if (code.value == kFewerPoints) return read_distance_of_points(begin);
    if (code.value == kRetract) return read_retract(code);
    if (code.value == kMachinePlaces) return make_machine_place(code);
    return std::nullopt;
  }
  // M124 T0.01: points closer than that are left out.
  std::optional<BlockError> read_distance_of_points(std::size_t begin) {
    const Profile::Keyword* keyword = find_keyword(profile_, "MPOINTS");
    if (keyword == nullptr) return strange(begin, 1);
    --block_.count;
    skip_blanks();
    if (at_ < end_ && text_[at_] == 'T') {
      ++at_;
      if (auto error = read_value('T', begin)) return error;
      --block_.count;
    }
    return add_code(*keyword, begin, at_);
  }
  // M140 MB MAX, M140 MB+50: the block's last word.
  std::optional<BlockError> read_retract(Word& code) {
    skip_blanks();
    const std::string_view by = name();
    skip_blanks();
    const std::string_view way = text_.substr(at_, end_ - at_);
    const KlartextNumber number = read_klartext_number(way);
    if (by != "MB" || (way != "MAX" && (number.length == 0 || number.length != way.size())))
      return wrong("E-MCODE", code.begin, "M140 in a form that is not known",
                   "where the tool goes is not sure",
                   "write M140 MB MAX or M140 MB and a number, at the end of its block");
    at_ = end_;
    code.end = static_cast<std::uint16_t>(end_);
    return std::nullopt;
  }
  // M91: the coordinates are the machine's own.
  std::optional<BlockError> make_machine_place(Word& code) {
    if (block_.words[0].letter == 'G' && block_.words[0].value > kLine && block_.words[0].value < kInch)
      return wrong("E-G53", code.begin, "M91 on an arc",
                   "whether its pole is a place of the machine's own is not sure", "go there on a line");
    if (block_.increments != 0)
      return wrong("E-G53", code.begin, "M91 with increments", "they count from the last M91 block",
                   "write the places themselves");
    code.letter = 'G';
    code.value = kMachinePlace;
    return std::nullopt;
  }
  std::optional<BlockError> read_feed(std::size_t begin, bool fastest) {
    if (std::exchange(has_feed_, true))
      return wrong("E-FEED", begin, "a second feed in one block", "which of them holds is not defined",
                   "keep one: FMAX goes at rapid, F at a feed");
    if (fastest) {
      if (block_.count == 0 || block_.words[0].letter != 'G' || block_.words[0].value != kLine)
        return wrong("E-FEED", begin, "FMAX on an arc", "whether the control obeys is not sure",
                     "give the arc a feed");
      block_.words[0].value = kRapid;
      return std::nullopt;
    }
    skip_blanks();
    if (text_.substr(at_, 4) != "AUTO") return read_value('F', begin);
    const std::size_t automatic = at_;
    const std::string_view word = name();
    const Profile::Keyword* keyword = find_keyword(profile_, word);
    if (keyword == nullptr || profile_.g[keyword->index].meaning != Meaning::copy)
      return strange(automatic, word.size());
    return add_code(*keyword, begin, at_);
  }

  std::optional<BlockError> read_tool(std::size_t begin) {
    skip_blanks();
    const std::string_view what = name();
    if (what == "DEF") return read_tool_definition();
    if (what != "CALL") return strange(begin, 4);
    const std::size_t behind = at_;
    skip_blanks();
    const std::size_t tool = at_;
    bool changes = false, none = false;
    if (at_ < end_ && text_[at_] == '"') {
      const std::size_t close = text_.substr(0, end_).find('"', at_ + 1);
      if (close == std::string_view::npos)
        return wrong("E-TOOL", tool, "the name of the tool has no end", "the tool is not known", "add '\"'");
      at_ = close + 1;
      changes = true;
      if (auto error = add('T', tool, tool, at_, 0)) return error;
    } else if (at_ < end_ && is_digit(text_[at_])) {
      changes = true;
      if (auto error = read_value('T', tool)) return error;
      none = block_.words[0].value == 0;
    }
    if (changes) {
      if (auto error = add('M', begin, begin, behind, 6)) return error;
      if (auto error = add('G', begin, begin, behind, none ? kNoLength : kLength)) return error;
    }
    return read_tool_words();
  }
  std::optional<BlockError> read_tool_words() {
    for (skip_blanks(); at_ < end_; skip_blanks()) {
      const std::size_t begin = at_;
      const std::string_view word = name();
      std::optional<BlockError> error;
      if (word == "Z") {
        if (at_ < end_ && !is_blank(text_[at_])) error = strange(begin, 1);
      } else if (word == "S" || word == "F") {
        error = read_value(word[0], begin);
      } else if (word == "DL" || word == "DR") {
        error = read_oversize(begin);
      } else {
        error = wrong("E-TOOL", begin, "a word of TOOL CALL that is not understood",
                      "the length of the tool, its axis or its radius may be another one",
                      "write TOOL CALL n Z S.. F..");
      }
      if (error) return error;
    }
    return std::nullopt;
  }
  std::optional<BlockError> read_oversize(std::size_t begin) {
    if (auto error = read_and_drop(begin)) return error;
    if (block_.words[static_cast<std::size_t>(block_.count)].value == 0) return std::nullopt;
    return wrong("E-TOOL", begin, "a tool with an allowance (DL, DR)",
                 "its length is not that of the tool table", "put the length into the tool table");
  }
  std::optional<BlockError> read_tool_definition() {
    skip_blanks();
    const std::size_t tool = at_;
    while (at_ < end_ && is_digit(text_[at_])) ++at_;
    if (at_ == end_) return copied();
    at_ = tool;
    if (auto error = read_value('T', tool)) return error;
    for (const char letter : {'L', 'R'}) {
      skip_blanks();
      const std::size_t word = at_;
      if (at_ == end_ || text_[at_] != letter) continue;
      ++at_;
      if (auto error = read_value(letter, word)) return error;
      block_.tool_data = true;
    }
    skip_blanks();
    if (at_ == end_ && block_.tool_data) return std::nullopt;
    return wrong("E-TOOL", at_, "a word of TOOL DEF that is not understood",
                 "the tool may be another one than in the tool table", "write TOOL DEF n L.. R..");
  }

  std::optional<BlockError> read_frame_of_program(std::size_t begin, bool starts) {
    skip_blanks();
    const std::string_view whole = text_.substr(begin, end_ - begin);
    const std::size_t last = whole.find_last_of(" \t");
    const std::string_view unit = last == std::string_view::npos ? whole : whole.substr(last + 1);
    if (name() != "PGM" || (unit != "MM" && unit != "INCH"))
      return wrong("E-START", begin, "not BEGIN PGM name MM or INCH", "the unit of all numbers is not known",
                   "write the block as the control does");
    if (!starts) return add('M', begin, begin, end_, 2);
    return add('G', begin, begin, end_, unit == "MM" ? kMm : kInch);
  }

  // "PLANE SPATIAL SPA+0 SPB+30 SPC+90 STAY", "PLANE RESET TURN FMAX".
  std::optional<BlockError> read_plane(std::size_t begin) {
    skip_blanks();
    const std::size_t kind_begin = at_;
    const std::string_view kind = name();
    const Profile::Keyword* keyword = find_keyword(profile_, kind);
    const Meaning meaning = keyword != nullptr ? profile_.g[keyword->index].meaning : Meaning::unknown;
    if (meaning != Meaning::spatial_plane && meaning != Meaning::plane_off)
      return wrong("E-PLANE", kind_begin, fmt::format("PLANE {} is not known", kind),
                   "where the plane lies, and how the tool gets there, is not followed",
                   "post PLANE SPATIAL SPA SPB SPC STAY and PLANE RESET STAY");
    if (auto error = add_code(*keyword, begin, at_)) return error;
    unsigned angles = 0;
    bool said = false, turns_table = false, turns = false;
    for (skip_blanks(); at_ < end_; skip_blanks()) {
      const std::size_t word_begin = at_;
      const std::string_view word = name();
      std::optional<BlockError> error;
      if (word == "STAY" || word == "TURN" || word == "MOVE") {
        said = true;
        turns = word != "STAY";
        error = add('P', word_begin, word_begin, at_, turns ? 1 : 0);
      } else if (word.size() == 3 && word.substr(0, 2) == "SP" && word[2] <= 'C') {
        angles |= 1U << (word[2] - 'A');
        error = read_value(static_cast<char>('I' + (word[2] - 'A')), word_begin);
      } else if (word == "SEQ" && at_ < end_ && (text_[at_] == '+' || text_[at_] == '-')) {
        const int side = text_[at_++] == '-' ? -1 : 1;
        error = add('Q', word_begin, word_begin, at_, side);
      } else if (word == "COORD" || word == "TABLE") {
        skip_blanks();
        turns_table = turns_table || word == "TABLE";
        if (name() != "ROT") error = strange(word_begin, word.size());
      } else if (word == "F" || word == "DIST") {
        error = read_and_drop(word_begin);  // how it gets there
      } else if (word != "FMAX") {
        error = strange(word_begin, word.size());
      }
      if (error) return error;
    }
    constexpr unsigned kAllAngles = 7;
    const unsigned needed = meaning == Meaning::spatial_plane ? kAllAngles : 0;
    if (angles == needed && said && !(turns && turns_table)) return std::nullopt;
    return wrong(
        "E-PLANE", begin, "a plane without all of its angles, without STAY, TURN or MOVE, or TABLE ROT",
        "where the rotary axes go is not known", "write SPA.. SPB.. SPC.. STAY, or TURN without TABLE ROT");
  }
  std::optional<BlockError> read_and_drop(std::size_t begin) {
    const int count = block_.count;
    auto error = read_value('R', begin);
    block_.count = count;
    return error;
  }

  std::optional<BlockError> read_cycle(std::size_t begin) {
    skip_blanks();
    const std::string_view what = name();
    if (what == "DEF") return read_definition(begin);
    if (what != "CALL") return strange(begin, at_ - begin);
    if (auto error = add('M', begin, begin, at_, kCallCycle)) return error;
    return read_others();
  }

  bool has_feed_ = false;   ///< F or FMAX stood in the block
  bool may_go_on_ = false;  ///< nothing is lost if the next line is taken for text
};

}  // namespace

std::optional<BlockNumber> read_block_number(std::string_view line) {
  BlockNumber number;
  while (number.begin < line.size() && is_blank(line[number.begin])) ++number.begin;
  for (number.end = number.begin; number.end < line.size() && is_digit(line[number.end]); ++number.end)
    number.value = 10 * number.value + static_cast<unsigned long>(line[number.end] - '0');
  if (number.end == number.begin || number.end - number.begin > kMostDigitsOfBlock) return std::nullopt;
  return number;
}

std::optional<BlockError> read_klartext_block(std::string_view line, const Profile& profile,
                                              KlartextContext& context, Block& block) {
  block.pole = Block::Pole::none;
  block.continues = context.open;
  block.cycle = 0;
  block.defines = block.tool_data = false;
  block.flow = Block::Flow::none;
  block.style = {true, context.comma};
  if (auto error = begin_block(line, block)) return error;
  return KlartextLine(profile, context, block).read();
}

}  // namespace abbe
