#include "abbe/verify/word_taker.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace abbe::verifying {
namespace {

/// Where a meaning goes in a block: its modal group as in LinuxCNC, and the code by which this reader knows
/// it.
struct Seat {
  std::int8_t group = -1;
  std::int16_t code = 0;
};
constexpr std::int8_t kNoGroup = -2;

constexpr Seat seat_of(Meaning meaning) {
  switch (meaning) {
    case Meaning::unknown:
      break;
    case Meaning::dwell:
      return {0, 40};
    case Meaning::set_data:
      return {0, 100};
    case Meaning::home:
      return {0, 280};
    case Meaning::other_home:
      return {0, 300};
    case Meaning::local_shift:
      return {0, 520};
    case Meaning::machine_coordinates:
      return {0, 530};
    case Meaning::set_position:
      return {0, 920};
    case Meaning::clear_position:
      return {0, 921};
    case Meaning::suspend_position:
      return {0, 922};
    case Meaning::restore_position:
      return {0, 923};
    case Meaning::rapid:
      return {1, 0};
    case Meaning::line:
      return {1, 10};
    case Meaning::arc_cw:
      return {1, 20};
    case Meaning::arc_ccw:
      return {1, 30};
    case Meaning::nurbs:
      return {1, 62};
    case Meaning::no_motion:
      return {1, 800};
    case Meaning::chip_break:
      return {1, 730};
    case Meaning::tap_left:
      return {1, 740};
    case Meaning::fine_bore:
      return {1, 760};
    case Meaning::drill:
      return {1, 810};
    case Meaning::drill_dwell:
      return {1, 820};
    case Meaning::peck:
      return {1, 830};
    case Meaning::tap:
      return {1, 840};
    case Meaning::bore:
      return {1, 850};
    case Meaning::bore_stop:
      return {1, 860};
    case Meaning::bore_dwell:
      return {1, 890};
    case Meaning::plane_xy:
      return {2, 170};
    case Meaning::plane_zx:
      return {2, 180};
    case Meaning::plane_yz:
      return {2, 190};
    case Meaning::absolute:
      return {3, 900};
    case Meaning::incremental:
      return {3, 910};
    case Meaning::centre_absolute:
      return {4, 901};
    case Meaning::centre_incremental:
      return {4, 911};
    case Meaning::inverse_time:
      return {5, 930};
    case Meaning::per_minute:
      return {5, 940};
    case Meaning::per_turn:
      return {5, 950};
    case Meaning::units_inch:
      return {6, 200};
    case Meaning::units_mm:
      return {6, 210};
    case Meaning::cutter_off:
      return {7, 400};
    case Meaning::cutter_left:
      return {7, 410};
    case Meaning::cutter_right:
      return {7, 420};
    case Meaning::cutter_left_direct:
      return {7, 411};
    case Meaning::cutter_right_direct:
      return {7, 421};
    case Meaning::tool_length:
      return {8, 430};
    case Meaning::tool_length_minus:
      return {8, 440};
    case Meaning::tool_length_direct:
      return {8, 431};
    case Meaning::tool_length_off:
      return {8, 490};
    case Meaning::retract_initial:
      return {10, 980};
    case Meaning::retract_r:
      return {10, 990};
    case Meaning::rotate:
      return {11, 680};
    case Meaning::rotate_off:
      return {11, 690};
    case Meaning::scale:
      return {11, 510};
    case Meaning::scale_off:
      return {16, 500};
    case Meaning::mirror:
      return {11, 511};
    case Meaning::mirror_off:
      return {17, 501};
    case Meaning::tilted_plane:
      return {11, 682};
    case Meaning::tool_to_plane:
      return {11, 531};
    case Meaning::frame_scale:
      return {0, 683};
    case Meaning::frame_scale_further:
      return {0, 684};
    case Meaning::frame_mirror:
      return {0, 685};
    case Meaning::frame_mirror_further:
      return {0, 686};
    case Meaning::turns_of_workpiece:
    case Meaning::turns_of_machine:
      return {18, -1};
    case Meaning::axes_evenly:
    case Meaning::tool_evenly:
      return {19, -1};
    case Meaning::bracket_cycle:
      return {20, -1};
    case Meaning::swivel_plane:
      return {11, 684};
    case Meaning::spatial_plane:
      return {11, 683};
    case Meaning::plane_off:
      return {11, 691};
    case Meaning::datum_turn:
      return {11, 692};
    case Meaning::datum_mirror:
      return {11, 512};
    case Meaning::datum_scale:
    case Meaning::datum_scale_evenly:
      return {11, 513};
    case Meaning::frame_shift:
      return {0, 521};
    case Meaning::frame_shift_further:
      return {0, 522};
    case Meaning::frame_turn:
      return {0, 681};
    case Meaning::frame_turn_further:
      return {0, 682};
    case Meaning::work_offset:
      return {12, 0};
    case Meaning::numbered_work_offset:
      return {12, Block::kFurtherOffset};
    case Meaning::path_control:
      return {13, -1};
    case Meaning::spindle_mode:
      return {14, -1};
    case Meaning::radius_mode:
      return {15, -1};
    case Meaning::exact_stop_once:
    case Meaning::tcp_on:
    case Meaning::tcp_off:
    case Meaning::transformation_off:
    case Meaning::modal_call:
    case Meaning::smoothing:
    case Meaning::copy:
    case Meaning::auxiliary:
      return {kNoGroup, -1};
    case Meaning::stop:
    case Meaning::end:
      return {Block::kStops, -1};
    case Meaning::call_subprogram:
      return {Block::kStops, 98};
    case Meaning::end_subprogram:
      return {Block::kStops, 99};
    case Meaning::signal:
      return {5, -1};
    case Meaning::cycle_call:
      return {Block::kCalls, 99};
    case Meaning::cycle_call_modal:
      return {Block::kCalls, 89};
    case Meaning::hole_cycle:
      break;
    case Meaning::retract_tool:
      return {Block::kRetracts, -1};
    case Meaning::shortest_way:
      return {Block::kWays, 126};
    case Meaning::straight_way:
      return {Block::kWays, 127};
    case Meaning::tool_change:
      return {6, 6};
    case Meaning::set_tool:
      return {6, 61};
    case Meaning::spindle:
      return {7, -1};
    case Meaning::coolant:
      return {8, -1};
    case Meaning::override_switch:
      return {9, -1};
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

}  // namespace

[[gnu::cold]] bool refuse(Fault& fault, std::size_t column, std::size_t length, const char* code,
                          std::string message, std::string why, std::string fix) {
  fault = {code, column, length, std::move(message), std::move(why), std::move(fix)};
  return false;
}

bool WordTaker::refuse_code(const std::string& name, const char* usual, const CodeUse& use,
                            std::size_t column) {
  const std::size_t length = at_ + 1 - column;
  if (use.refusal == 0)
    return refuse(fault_, column, length, usual,
                  fmt::format("{} is not understood for {}", name, profile_.title),
                  "an unknown code may move the machine or change its state",
                  "post the program without it (abbe profiles lists the codes known)");
  const CodeRefusal& refusal = profile_.refusals[use.refusal - 1U];
  // what the profile calls it
  const char* code = refusal.error.empty() ? usual : refusal.error.c_str();
  return refuse(fault_, column, length, code, fmt::format("{} is refused", name), refusal.why, refusal.fix);
}

bool WordTaker::extra(char kind, const CodeUse& use, int code, std::string_view text, std::size_t column) {
  if (block_.extra_count == Block::kMaxExtras)
    return refuse(fault_, column, at_ + 1 - column, "E-BLOCK", "too many codes in a block",
                  "no control accepts such a block", "use two blocks");
  const bool after = use.after || use.meaning == Meaning::exact_stop_once;
  block_.extras[static_cast<std::size_t>(block_.extra_count++)] = {
      kind, after, static_cast<std::int16_t>(code), use.words, text};
  return true;
}

bool WordTaker::g_word(double value, std::size_t column) {
  static constexpr CodeUse kUnknown{};
  int number = -1;
  const bool is_code =
      whole(value * 10, number) && number >= 0 && number < static_cast<int>(Profile::kGCodes);
  const bool switches = tcp_switch('G', number);
  static constexpr CodeUse kTcpLength{Meaning::tool_length, false, 0, 0, letters('H')};
  // G43.4 H and G43.5 H apply the tool length as G43 does
  const bool with_length = switches && (number == 434 || number == 435);
  const CodeUse& use = with_length ? kTcpLength
                       : is_code   ? profile_.g[static_cast<std::size_t>(number)]
                                   : kUnknown;
  if (switches && use.meaning == Meaning::unknown) return true;
  return take_code({}, value, number, use, {}, column);
}

bool WordTaker::keyword(const Profile::Keyword& word, std::string_view text, std::size_t column) {
  const CodeUse& use = profile_.g[word.index];
  if (use.meaning == Meaning::tcp_on || use.meaning == Meaning::tcp_off) {
    block_.tcp_letter = 'G';
    block_.tcp_code = static_cast<int>(word.index);
    block_.tcp = use.meaning == Meaning::tcp_on;
    block_.tcp_vectors = false;
    return true;
  }
  return take_code(word.name, 0, static_cast<int>(word.index), use, text, column);
}

/// Into its modal group, or beside the others. `word`: its name if it is a word; else it is G and the value.
bool WordTaker::take_code(std::string_view word, double value, int number, const CodeUse& use,
                          std::string_view text, std::size_t column) {
  const Seat seat = seat_of(use.meaning);
  if (seat.group == kNoGroup) return extra('G', use, number, text, column);
  const auto name = [&] { return word.empty() ? fmt::format("G{:g}", value) : std::string(word); };
  if (seat.group < 0) return refuse_code(name(), "E-GCODE", use, column);
  const int code = use.meaning == Meaning::work_offset ? use.number - 1 : seat.code >= 0 ? seat.code : number;
  const auto group = static_cast<std::size_t>(seat.group);
  const std::uint32_t bit = std::uint32_t{1} << group;
  if ((block_.g_groups & bit) != 0) {
    // G80 may stand beside another motion code, which then counts alone.
    constexpr int no_motion = 800;
    if (code == no_motion) return true;
    if (block_.g[group] != no_motion)
      return refuse(fault_, column, at_ + 1 - column, "E-BLOCK",
                    fmt::format("{}: two codes of one group in a block", name()),
                    "they contradict each other", "use two blocks");
  }
  constexpr int frames = 11;
  if (seat.group == frames) block_.frame_text = text;
  block_.g_groups |= bit;
  block_.g[group] = static_cast<std::int16_t>(code);
  block_.g_column[group] = static_cast<std::uint8_t>(column);
  block_.g_words[group] = use.words;
  return true;
}

/// Notes a code that switches tool centre point control; false: it is none.
bool WordTaker::tcp_switch(char letter, int code) {
  for (const TcpCode& known : tcp_codes_) {
    if (known.letter != letter || known.code != code) continue;
    block_.tcp_letter = letter;
    block_.tcp_code = code;
    block_.tcp = known.on;
    block_.tcp_vectors = known.vectors;
    return true;
  }
  return false;
}

bool WordTaker::m_word(double value, std::size_t column) {
  static constexpr CodeUse kUnknown{};
  int number = -1;
  const bool is_code = whole(value, number) && number >= 0 && number < static_cast<int>(Profile::kMCodes);
  if (tcp_switch('M', 10 * number)) return true;
  const CodeUse& use = is_code ? profile_.m[static_cast<std::size_t>(number)] : kUnknown;
  const Seat seat = seat_of(use.meaning);
  if (seat.group == kNoGroup) return extra('M', use, number, {}, column);
  if (seat.group < 0) return refuse_code(fmt::format("M{:g}", value), "E-MCODE", use, column);
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

bool WordTaker::value_word(char letter, double value, std::size_t column, bool first) {
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

}  // namespace abbe::verifying
