#include "abbe/verify/control.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "abbe/core/units.h"

namespace abbe::verifying {
namespace {

constexpr Letters kAxisLetters = letters('X', 'Y', 'Z');
constexpr Letters kTurnLetters = letters('A', 'B', 'C');
constexpr Letters kCentreLetters = letters('I', 'J', 'K');
constexpr int kNoMotion = 800, kNurbs = 62;

bool is_cycle(int code) { return code >= 730 && code != kNoMotion; }

}  // namespace

Control::Control(const ControlSetup& setup, const Rotary* rotary)
    : shared_profile_(profile_of(setup)),
      profile_(*shared_profile_),
      frames_(frames_of(setup, profile_)),
      tools_(setup.tools),
      radii_(setup.radii),
      tool_(setup.loaded_tool),
      tool_change_keeps_place_(setup.tool_change_keeps_place),
      rotary_(rotary),
      turns_(setup.start_turns),
      tcp_(rotary != nullptr && rotary->starts_with_tcp()),
      edge_stated_(profile_.tools.edges == Profile::Tools::Edges::none) {
  if (profile_.start.units == Profile::Units::imperial) unit_ = abbe::inch;
  incremental_ = profile_.start.distance == Profile::Distance::incremental;
  retracts_to_r_ = profile_.start.retract_to_r;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!setup.start[i]) continue;
    m_.at[static_cast<Eigen::Index>(i)] = *setup.start[i];
    m_.known |= Axes{1} << i;
  }
  u_ = program_of(frames_, m_);
}

bool Control::refuse(std::size_t column, const char* code, std::string message, std::string why,
                     std::string fix) {
  *fault_ = {code, column, 1, std::move(message), std::move(why), std::move(fix)};
  return false;
}

bool Control::refuse_at(char letter, const char* code, std::string message, std::string why,
                        std::string fix) {
  return refuse(block_->has(letter) ? block_->column_of(letter) : 1, code, std::move(message), std::move(why),
                std::move(fix));
}

bool Control::use(char letter) {
  const Letters bit = letter_bit(letter);
  if ((used_ & bit) != 0)
    return refuse_at(letter, "E-BLOCK", fmt::format("two codes of this block use the {} word", letter),
                     "it is not defined which one it belongs to", "use two blocks");
  used_ |= bit;
  return true;
}

bool Control::whole_word(char letter, int& out, const char* code) {
  const double value = (*block_)[letter];
  const double nearest = std::round(value);
  if (!(std::abs(value - nearest) <= 1e-4) || nearest < 0 || nearest > 1e6)
    return refuse_at(letter, code, fmt::format("{}{:g} is not a whole number in range", letter, value),
                     "it counts or names something", "correct the number");
  out = static_cast<int>(nearest);
  return true;
}

void Control::fill(Event& event, EventKind kind, int code, Letters words) const {
  event.kind = kind;
  event.code = code;
  event.sets_position = event.sets_frames = false;
  event.words = block_->words & words;
  event.text = {};
  std::size_t n = 0;
  for (std::size_t i = 0; i < Block::kLetters && n < event.values.size(); ++i)
    if ((event.words >> i & 1) != 0) event.values[n++] = block_->value[i];
  for (; n < event.values.size(); ++n) event.values[n] = 0;
}

Event& Control::add(EventKind kind, int code, Letters words) {
  Event& event = events_[event_count_++];
  fill(event, kind, code, words);
  return event;
}

bool Control::frame_known() {
  if (frames_.system().defined == kAllAxes) return true;
  const std::string name = work_offset_label(frames_.active);
  return refuse(1, "E-WCS", fmt::format("the origin of {} is not known", name),
                "errors depend on where the machine's axes stand",
                fmt::format("give --offset {}=X..,Y..,Z..", name));
}

bool Control::execute(const Block& block, Fault& fault) {
  block_ = &block;
  fault_ = &fault;
  used_ = 0;
  event_count_ = after_count_ = 0;
  moves_ = drills_ = false;
  motion_code_ = -1;
  covets_ = false;
  if (block.pole == Block::Pole::set) return set_pole();
  if (block.hole.cycle != 0) return profile_.text.conversational ? define_hole() : define_bracket();
  if (block.tool_data) return check_tool();
  if (block.flow != Block::Flow::none) {
    add_comments();  // LBL is a text; the reader goes where it says
    flow_ = block.flow == Block::Flow::call  ? kCallLabel
            : block.flow == Block::Flow::end ? kEndLabel
                                             : kLabel;
    return true;
  }
  if (block.pointless != 0 && !settle_numbers()) return false;
  return execute_settled();
}

/// CC X Y: where the arcs that follow have their centre. Nothing else happens.
bool Control::set_pole() {
  pole_ = std::array{length_word('X') + frames_.g92.x(), length_word('Y') + frames_.g92.y()};
  add_comments();
  return true;
}

void Control::add_comments() {
  for (int i = 0; i < block_->comment_count; ++i)
    add(EventKind::comment, 0).text = block_->comments[static_cast<std::size_t>(i)];
}

/// What executing a block means once its numbers are in units.
bool Control::execute_settled() {
  const Block& block = *block_;
  // Most blocks: axis words for the line or rapid in force, and nothing else.
  const bool words_of_axes = block.words != 0 && (block.words & ~kAxisLetters) == 0;
  if (words_of_axes && (block.g_groups | block.m_groups) == 0 &&
      (block.comment_count | block.extra_count) == 0 && block.tcp_code < 0 && block.places == 0 &&
      (mode_ == 0 || mode_ == 10) && !drills_always_) {
    motion_code_ = mode_;
    return move();
  }

  if (block.has('N')) {
    if (!use('N')) return false;
    add(EventKind::block_number, 0, letter_bit('N'));
  }
  add_comments();
  if ((block.words & kTurnLetters) != 0 && !turn_words_allowed()) return false;
  if (!choose_motion() || !cutter_permits()) return false;
  constexpr std::uint32_t motion_group = 1u << 1;
  const bool plain = (block.g_groups & ~motion_group) == 0 && block.m_groups == 0 && block.extra_count == 0 &&
                     block.g_code(1) != kNoMotion && (block.words & letters('S', 'T', 'D')) == 0 &&
                     block.tcp_code < 0;
  if (plain) {
    if (!feed_words()) return false;
  } else {
    if (!settings() || !modes() || !placement_allows() || !datum_allows() || !non_modal()) return false;
  }
  if (!move() || !drill()) return false;
  return stops() && leftovers();
}

/// Which motion the block makes, if any, and whether its axis words belong to something else.
bool Control::choose_motion() {
  const Block& b = *block_;
  const int group0 = b.g_code(0), explicit_motion = b.g_code(1);
  const bool axis_words = (b.words & (kAxisLetters | kTurnLetters)) != 0 || direction_named();
  const bool offset_words = b.g_code(8) == 431;
  const bool times_by_x = group0 == 40 && (b.g_words[0] & letter_bit('X')) != 0;
  const int frame = b.g_code(11);
  const bool turns =
      frame == 680 || frame == 682 || (frame >= 510 && frame <= 513) || (b.g_code(17) >= 0 && axis_words);
  const bool takes_axes = group0 == 100 || group0 == 280 || group0 == 300 ||
                          (group0 >= 520 && group0 <= 522) || (group0 >= 683 && group0 <= 686) ||
                          group0 == 920 || times_by_x || turns;
  const bool turns_anew = group0 == 681 || group0 == 682;  // ROT, AROT
  if (takes_axes || offset_words || group0 >= 921 || turns_anew) {
    covets_ = true;
    const std::size_t column = group0 >= 0 ? b.g_column[0] : turns ? b.g_column[11] : b.g_column[8];
    const bool only_mode = profile_.home_beside_motion && (group0 == 280 || group0 == 300) &&
                           (explicit_motion == 0 || explicit_motion == 10);
    if (explicit_motion >= 0 && explicit_motion != kNoMotion && !only_mode)
      return refuse(column, "E-BLOCK", "a motion code together with a code that uses up the axis words",
                    "the axis words can belong to one of them only", "use two blocks");
    if ((takes_axes && offset_words) || (axis_words && !takes_axes && !offset_words))
      return refuse(column, "E-BLOCK", "axis words in a block whose code does not take them",
                    "it is not defined whether the machine moves", "use two blocks");
  }
  if (explicit_motion >= 0) {
    mode_ = is_cycle(explicit_motion) ? mode_
                                      : explicit_motion;  // a cycle becomes the mode after its first block
    if (is_cycle(explicit_motion)) motion_code_ = explicit_motion;
    if (explicit_motion == 20 || explicit_motion == 30 || explicit_motion == kNurbs)
      motion_code_ = explicit_motion;
    if ((explicit_motion == 0 || explicit_motion == 10) && axis_words && !covets_)
      motion_code_ = explicit_motion;
    if (explicit_motion == kNoMotion && axis_words && !covets_)
      return refuse(b.g_column[1], "E-MODE", "axis words with G80", "no motion is active to use them",
                    "give the motion code");
  } else if (!covets_ && (axis_words || (mode_ == kNurbs && b.has('K')) ||
                          ((mode_ == 20 || mode_ == 30) && (b.words & kCentreLetters) != 0))) {
    if (mode_ == kNoMotion)
      return refuse_at(b.has('X')   ? 'X'
                       : b.has('Y') ? 'Y'
                                    : 'Z',
                       "E-MODE", "axis words without a motion code",
                       "no motion is active: the control stops here", "begin with G0, G1, G2 or G3");
    motion_code_ = mode_;
  }
  const bool in_increments = b.g_code(3) >= 0 ? b.g_code(3) == 910 : incremental_;
  if (profile_.text.names && (b.increments | b.places) != 0 &&
      (covets_ || group0 == 530 || (b.places != 0 && in_increments)))
    return refuse(1, "E-BLOCK", "AC or IC in such a block", "what it means there is not defined",
                  "write places in G90");
  if (group0 == 530) {
    const int distance = b.g_code(3) >= 0 ? b.g_code(3) : incremental_ ? 910 : 900;
    const int motion = motion_code_ >= 0 ? motion_code_ : explicit_motion >= 0 ? explicit_motion : mode_;
    if (distance == 910)
      return refuse(b.g_column[0], "E-G53", "G53 in G91",
                    "controls disagree whether its words are increments", "use G90");
    if (motion != 0 && motion != 10)
      return refuse(b.g_column[0], "E-G53", "G53 needs G0 or G1",
                    "only straight moves go in machine coordinates", "give G0 or G1 in the block");
  }
  return true;
}

bool Control::feed_words() {
  // F AUTO: the feed of TOOL CALL, which the last F need not be
  const Profile::Keyword* automatic = profile_.text.conversational ? find_keyword(profile_, "AUTO") : nullptr;
  for (int i = 0; automatic != nullptr && i < block_->extra_count; ++i) {
    if (block_->extras[static_cast<std::size_t>(i)].code != static_cast<int>(automatic->index)) continue;
    feed_ = 0;
    feed_stated_ = false;
  }
  if (!block_->has('F')) return true;
  if (!use('F')) return false;
  feed_ = (*block_)['F'];
  feed_stated_ = true;
  if (feed_ < 0)
    return refuse_at('F', "E-FEED", "negative feed", "a feed is a speed without direction",
                     "correct the F word");
  const bool belongs_to_motion = feed_mode_ == 930 && motion_code_ >= 10 && motion_code_ <= 30;
  if (!belongs_to_motion) add(EventKind::feed, 0, letter_bit('F'));
  return true;
}

bool Control::settings() {
  const Block& b = *block_;
  if (const int code = b.g_code(5); code >= 0) {
    feed_mode_ = code;
    add(EventKind::g_code, code);
  }
  const bool dwells_by_f = b.g_code(0) == 40 && (b.g_words[0] & letter_bit('F')) != 0;
  if (!dwells_by_f && !feed_words()) return false;
  const bool dwells_by_s = b.g_code(0) == 40 && (b.g_words[0] & letter_bit('S')) != 0;
  if (b.has('S') && !dwells_by_s) {
    if (!use('S')) return false;
    add(EventKind::speed, 0, letter_bit('S'));
  }
  if (const int code = b.g_code(14); code >= 0) {
    if (!use_all(b.g_words[14])) return false;
    add(EventKind::g_code, code, b.g_words[14]);
  }
  if (b.has('T')) {
    if (!select_tool()) return false;
  }
  if (!m_codes()) return false;
  if (b.g_code(0) == 40) {
    if ((b.words & b.g_words[0]) == 0)
      return refuse(b.g_column[0], "E-WORD", "G4 without a time", "the dwell time is missing", "add P");
    if (!use_all(b.g_words[0])) return false;
    add(EventKind::g_code, 40, b.g_words[0]);
  }
  return extras(false) && ends_modal_call();
}

bool Control::m_codes() {
  const Block& b = *block_;
  if (b.m_groups == 0) return true;
  if (const int code = b.m_code(6); code >= 0 && !tool_codes(code)) return false;
  for (const int group : {7, 8, 9, 5, Block::kWays, Block::kRetracts})
    if ((b.m_after >> group & 1) == 0 && !m_code(group)) return false;
  return ways_agree() && retract();
}

bool Control::tool_codes(int code) {
  const std::size_t column = block_->m_column[6];
  if (code == 6) {
    if (!selected_)
      return refuse(column, "E-TOOL", "M6 without a T word before it", "the tool in the spindle is not known",
                    "select the tool with T");
    tool_ = selected_;
    edge_stated_ = profile_.tools.edges == Profile::Tools::Edges::none;
    add(EventKind::m_code, 6);
    // Where the control changes tools (TOOL_CHANGE_POSITION and others of its configuration) it stays.
    if (!tool_change_keeps_place_) {
      unknown_turns_ = commanded_turns_;
      m_ = Position{};
      u_ = program_of(frames_, m_);
    }
    return true;
  }
  int number = 0;
  if (!block_->has('Q'))
    return refuse(column, "E-TOOL", "M61 without Q", "the tool in the spindle is not known", "add Q");
  if (!use('Q') || !whole_word('Q', number, "E-TOOL")) return false;
  tool_ = number;
  add(EventKind::m_code, 61, letter_bit('Q'));
  return true;
}

bool Control::modes() {
  const Block& b = *block_;
  if (b.g_groups == 0 && b.tcp_code < 0 && !b.has('D')) return true;
  const auto change = [&](int group) {
    const int code = b.g_code(group);
    if (code >= 0) add(EventKind::g_code, code);
    return code;
  };
  if (b.g_code(1) == kNoMotion) add(EventKind::g_code, kNoMotion);
  if (const int code = change(2); code >= 0) plane_ = code;
  if (const int code = change(6); code >= 0) {
    unit_ = code == 200 ? abbe::inch : abbe::mm;
    cycle_r_ = cycle_z_ = cycle_q_ = cycle_level_ = std::nullopt;  // sticky numbers of another unit
  }
  if (const int code = b.g_code(8); code >= 0 && !tool_offset(code)) return false;
  if (!edge()) return false;
  if (const int code = b.g_code(7); code >= 0 && !switch_cutter(code)) return false;
  if (b.tcp_code >= 0) {
    if (b.tcp && (rotary_ == nullptr || !rotary_->declared()))
      return refuse(1, "E-TCP", "tool centre point control without a model of the control",
                    "where the tip goes is not known", "declare [control] in the machine file");
    if (!switch_tcp(b.tcp)) return false;
    directs_by_centre_words_ = b.tcp && b.tcp_vectors;
    const bool g = b.tcp_letter == 'G';
    add(g ? EventKind::g_code : EventKind::m_code, g ? b.tcp_code : b.tcp_code / 10);
  }
  if (const int code = b.g_code(12); code >= 0) {
    int index = code;
    if (code == Block::kFurtherOffset) {
      int number = 0;
      if (!b.has('P') || !use('P') || !whole_word('P', number, "E-WCS"))
        return refuse(b.g_column[12], "E-WCS", "a further work offset without its number P",
                      "the frame is not known", "add P");
      if (number < 1 || number > profile_.offsets.further)
        return refuse_at('P', "E-WCS", fmt::format("there is no work offset P{}", number),
                         "the frame is not known", "correct the P word");
      index = kFixedWorkOffsets - 1 + number;
    }
    if (!profile_.offsets.keeps_shift && frames_.g92 != Vec3::Zero())
      return refuse(b.g_column[12], "E-FRAME", "another work offset while a shift of the program is in force",
                    "it is not defined whether the shift stays", "end the shift first");
    const Vec3 zero = zero_of(frames_);
    pole_.reset();  // whether it moves with the frame is not sure
    frames_.active = index;
    u_ = program_of(frames_, m_);
    move_zero(zero);
    add(EventKind::g_code, 540, code == Block::kFurtherOffset ? letter_bit('P') : 0).sets_frames = true;
  }
  if (!end_stretches()) return false;
  if (const int code = b.g_code(11); code >= 0 && !change_frame(code)) return false;
  if (const int code = b.g_code(13); code >= 0) {
    if (!use_all(b.g_words[13])) return false;
    add(EventKind::g_code, code, b.g_words[13]);
  }
  if (const int code = change(3); code >= 0) incremental_ = code == 910;
  if (const int code = change(4); code >= 0) absolute_centres_ = code == 901;
  if (const int code = change(10); code >= 0) retracts_to_r_ = code == 990;
  change(15);
  note_turn_codes();
  return true;
}

bool Control::tool_offset(int code) {
  const Block& b = *block_;
  Letters words = 0;
  const bool incremental = b.g_code(3) >= 0 ? b.g_code(3) == 910 : incremental_;
  constexpr Axes kZ = 4;
  const bool moves_itself = profile_.tools.moves && (!b.has('Z') || incremental);
  if (moves_itself) {  // parameters say whether the axis moves at once
    m_.known &= ~kZ;
    m_.at[2] = 0;
  }
  const bool cancels = profile_.tools.h_needed && b.has('H') && b['H'] == 0;
  // With tool centre point control the tip moves to the new length while the axes stand; on a tilted plane
  // the length acts across it, and the coordinates stay.
  const bool tcp = tcp_, keeps = frames_.placement.kind == Placement::Kind::plane;
  const Position coordinates = u_;
  if (!keeps && !switch_tcp(false)) return false;
  if (code == 490 || (cancels && code != 431)) {
    frames_.tool_offset = Vec3::Zero();
    if (cancels) {
      words = letter_bit('H');
      if (!use('H')) return false;
    }
  } else if (code == 431) {
    words = kAxisLetters;
    for (int i = 0; i < 3; ++i) {
      const char letter = static_cast<char>('X' + i);
      if (!use_optional(letter)) return false;
      if (b.has(letter)) frames_.tool_offset[i] = length_word(letter);
    }
  } else {
    words = letter_bit('H');
    std::optional<int> number = profile_.tools.h_needed ? std::nullopt : tool_;
    if (profile_.tools.edges == Profile::Tools::Edges::table) {
      int row = 0;
      if (!whole_word('D', row, "E-TOOL")) return false;
      number = row;
    }
    if (b.has('H')) {
      int h = 0;
      if (!use('H') || !whole_word('H', h, "E-TOOL")) return false;
      number = h;
    }
    const auto entry = number ? tools_.find(*number) : tools_.end();
    if (entry == tools_.end())
      return refuse(b.g_code(8) >= 0 ? b.g_column[8] : b.column_of('D'), "E-TOOL",
                    number ? fmt::format("tool {} is not in the tool table", *number)
                           : std::string("G43 without H, and no tool is loaded"),
                    "its offset moves the machine", "give the tool table with --tools");
    const auto& offset = entry->second.offset;
    frames_.tool_offset = Vec3(offset[0], offset[1], offset[2]);
    if (profile_.tools.z_only) frames_.tool_offset = Vec3(0, 0, offset[2]);
    if (code == 440) frames_.tool_offset = -frames_.tool_offset;
  }
  if (keeps) {
    u_ = coordinates;
    if (moves_itself) u_.known &= ~kZ;
    m_ = machine_of(frames_, u_);
  } else {
    u_ = program_of(frames_, m_);
    if (!switch_tcp(tcp)) return false;
  }
  add(EventKind::g_code, code, words).sets_frames = true;
  return true;
}

bool Control::non_modal() {
  switch (block_->g_code(0)) {
    case 100:
      return set_system();
    case 280:
    case 300:
      for (const char letter : {'X', 'Y', 'Z', 'A', 'B', 'C'})
        if (!use_optional(letter)) return false;
      if (named_axes(*block_) != 0 && !frame_known()) return false;
      if (block_->has('P') && (block_->g_words[0] & letter_bit('P')) != 0) {
        if (!use('P')) return false;
        add(EventKind::g_code, block_->g_code(0), letter_bit('P'));
      }
      go_home(block_->g_code(0));
      return true;
    case 521:
    case 522:
    case 681:
    case 682:
      return make_frame(block_->g_code(0));
    case 683:
    case 684:
    case 685:
    case 686:
      return stretch(block_->g_code(0));
    case 520:
    case 920:
    case 921:
    case 922:
    case 923:
      return set_g92(block_->g_code(0));
    default:
      return true;
  }
}

bool Control::stops() {
  if (block_->m_after == 0 && block_->extra_count == 0) return true;
  if (!extras(true)) return false;
  for (const int group : {7, 8, 9, 5, Block::kStops})
    if ((block_->m_after >> group & 1) != 0 && !m_code(group)) return false;
  const int code = block_->m_code(Block::kStops);
  ended_ = code == 2 || code == 17 || code == 30;
  return code < 98 || change_flow(code);
}

bool Control::leftovers() {
  const Letters left = block_->words & ~used_;
  if (left == 0) return true;
  for (char letter = 'A'; letter <= kVectorLetters.back(); ++letter)
    if ((left & letter_bit(letter)) != 0)
      return refuse_at(letter, "E-WORD", fmt::format("nothing in this block uses the {} word", letter),
                       "the control stops here", "remove it or add the code it belongs to");
  return true;
}

}  // namespace abbe::verifying
