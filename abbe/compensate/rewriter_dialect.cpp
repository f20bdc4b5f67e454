// What controls differ in before a block means anything: their text, their numbers, what holds at the start.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/compensate/rewriter.h"

namespace abbe {
namespace {

/// Words that are lengths or angles, so that a missing point may change their unit.
constexpr LetterSet kDimensions = letter_set("XYZIJKRABC");

bool has_point(const Block& block, const Word& word) {
  return block.text.substr(word.number, static_cast<std::size_t>(word.end - word.number)).find('.') !=
         std::string_view::npos;
}

int digits_of(const Block& block, const Word& word) {
  const std::string_view number =
      block.text.substr(word.number, static_cast<std::size_t>(word.end - word.number));
  const std::size_t first = number.find_first_of("123456789");
  if (first == std::string_view::npos) return 0;
  return static_cast<int>(std::count_if(number.begin() + static_cast<std::ptrdiff_t>(first), number.end(),
                                        [](char c) { return c >= '0' && c <= '9'; }));
}

/// Digits after the point without the zeros at the end.
int written_decimals(const Block& block, const Word& word) {
  int zeros = 0;
  for (std::size_t at = word.end; at > word.number && block.text[at - 1] == '0' && zeros < word.decimals;
       --at)
    ++zeros;
  return word.decimals - zeros;
}

}  // namespace

// False: the line is not written as this control expects it.
bool Rewriter::read_text_rules() {
  const Profile::Text& rules = profile_.text;
  if (block_->count > 0 && block_->text.size() > rules.block_bytes) {
    refuse_block(
        "E-LINELEN",
        fmt::format("the line has {} bytes, {} is the limit", block_->text.size(), rules.block_bytes),
        "the control refuses longer lines", "break the block into two");
    return false;
  }
  const char* strange = block_->has_semicolon && !rules.semicolon ? "a comment that begins with ';'"
                        : block_->percent && !rules.percent       ? "'%'"
                        : block_->slash && rules.skip == Profile::Skip::none ? "'/'"
                                                                             : nullptr;
  if (strange != nullptr) {
    findings_.add(Severity::error, "E-CHAR", number_, block_->text, 0, 1,
                  fmt::format("{}: not part of the {} dialect", strange, profile_.title),
                  "the control stops there, or reads it as something else",
                  "remove it, or name the control the program is for");
  }
  return strange == nullptr;
}

// Numbers without a point, and with more digits than the control resolves. False: refused.
bool Rewriter::settle_numbers() {
  using IntegerWords = Profile::IntegerWords;
  const Profile::Numbers& rules = profile_.numbers;
  const int decimals = modal_.inch ? rules.decimals_inch : rules.decimals_mm;
  bool good = true;
  for (int i = 0; i < block_->count; ++i) {
    Word& word = block_->words[static_cast<std::size_t>(i)];
    const bool time = word.letter == 'F' && modal_.feed_mode == 930;
    const bool cycle_k = word.letter == 'K' && is_cycle(instruction_.motion);
    if ((kDimensions & letter_set({&word.letter, 1})) == 0 && !time) continue;
    if (cycle_k || word.value == 0) continue;
    const bool of_curve = instruction_.motion == kNurbs && (word.letter == 'K' || word.letter == 'R');
    if (of_curve && (has_point(*block_, word) || rules.integer_words == IntegerWords::units)) continue;
    const auto index = static_cast<std::int8_t>(i);
    const bool direction = instruction_.directs_tool && std::count(instruction_.direction.begin(),
                                                                   instruction_.direction.end(), index) > 0;
    if (direction && (has_point(*block_, word) || rules.integer_words == IntegerWords::units)) continue;
    const bool angle = (word.letter == 'R' && instruction_.frame == FrameChange::turn) ||
                       (word.letter >= 'A' && word.letter <= 'C') ||
                       (word.letter >= 'I' && word.letter <= 'K' && instruction_.frame == FrameChange::plane);
    if (!has_point(*block_, word) && rules.integer_words != IntegerWords::units) {
      if (rules.integer_words == IntegerWords::ask || time || of_curve || direction) {
        refuse(word, "E-DECIMAL",
               fmt::format("{}: a number without a decimal point",
                           block_->text.substr(word.begin, static_cast<std::size_t>(word.end - word.begin))),
               "this control counts it in units or in its smallest increment, as a parameter says: a factor "
               "of a thousand",
               "say which: --integer-words units or increments; or post with points");
        good = false;
        continue;
      }
      word.value *= std::pow(10.0, angle ? -rules.decimals_degree : -decimals);
    }
    if (rules.finer || time) continue;
    if (written_decimals(*block_, word) > (angle ? rules.decimals_degree : decimals) ||
        (rules.digits > 0 && digits_of(*block_, word) > rules.digits)) {
      refuse(word, "E-DIGITS",
             fmt::format("{}: more digits than the control resolves",
                         block_->text.substr(word.begin, static_cast<std::size_t>(word.end - word.begin))),
             "it drops them, rounds or stops",
             "post with its decimals, or set numbers.decimals in a profile of your own");
      good = false;
    }
  }
  return good;
}

// False: this motion depends on what the program has not said.
bool Rewriter::may_move() {
  const bool in_work = instruction_.moves_axes || is_arc(instruction_.motion);
  if (in_work && (!modal_.units_stated || (!modal_.distance_stated && instruction_.zero != 530))) {
    const bool units = !modal_.units_stated;
    refuse_block("E-START",
                 units ? "a motion before the program says inches or millimetres"
                       : "a motion before the program says G90 or G91",
                 "what the control does depends on what ran before",
                 units ? "write G21 or G20 (BEGIN PGM .. MM) at the top, or give --units"
                       : "write G90 at the top, or state start.distance in a profile of your own");
    modal_.units_stated = modal_.distance_stated = modal_.stated = true;  // said once
    return false;
  }
  if (in_work && !modal_.offset_stated && instruction_.zero != 530) {
    refuse_block("E-START", "a motion before the program chooses a work offset",
                 "which one is in force at the start depends on the control's settings",
                 "write G54 at the top, or state start.offset in a profile of your own");
    modal_.offset_stated = true;  // said once
    modal_.stated = all_stated(modal_);
    return false;
  }
  if (in_work && !modal_.edge_stated) {
    refuse_block("E-TOOL", "a motion before D says which tool offset is in force",
                 "after a tool change and at the start it depends on the control's settings",
                 "write D1 with the tool, or D0");
    modal_.edge_stated = true;  // said once
    modal_.stated = all_stated(modal_);
    return false;
  }
  if (instruction_.tool_change && !profile_.tools.change_first) {
    refuse_block("E-AUX", "a tool change and a motion in one block",
                 "whether the machine moves before or after it depends on its builder", "split the block");
    return false;
  }
  if (offset_doubtful_ && axis_word(2) != nullptr && instruction_.zero != 530 &&
      in_.frames.tool_offset() != Vec3::Zero()) {
    refuse_block("E-TOOL", "Z after a reference return, without its tool offset",
                 "parameters say whether the control has dropped the offset",
                 "write G43 H.. with the first Z after it");
    offset_doubtful_ = false;
    return false;
  }
  if (instruction_.zero == 530)
    offset_doubtful_ = offset_doubtful_ || (profile_.tools.home_cancels && axis_word(2) != nullptr);
  return true;
}

}  // namespace abbe
