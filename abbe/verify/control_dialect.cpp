// What controls differ in: codes without a group, numbers without a point, rotations made by the program.
#include <fmt/format.h>

#include <cmath>

#include "abbe/core/units.h"
#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

constexpr Letters kAxisWords = letters('X', 'Y', 'Z');

bool is_cycle(int code) { return code >= 730 && code != 800; }

}  // namespace

/// Codes without a group, before or after the motion.
bool Control::extras(bool after) {
  for (int i = 0; i < block_->extra_count; ++i) {
    const Block::Extra& extra = block_->extras[static_cast<std::size_t>(i)];
    if (extra.after != after) continue;
    if (!use_all(extra.words)) return false;
    const EventKind kind = extra.kind == 'G' ? EventKind::g_code : EventKind::m_code;
    Event& event = after ? after_[after_count_++] : events_[event_count_++];
    fill(event, kind, extra.code, extra.words);
    event.text = extra.text;
  }
  return true;
}

/// The M code of a group and its words, before or after the motion.
bool Control::m_code(int group) {
  const int code = block_->m_code(group);
  if (code < 0) return true;
  const Letters words = block_->m_words[static_cast<std::size_t>(group)];
  if (!use_all(words)) return false;
  const bool after = (block_->m_after >> group & 1) != 0;
  fill(after ? after_[after_count_++] : events_[event_count_++], EventKind::m_code, code, words);
  return true;
}

bool Control::use_all(Letters letters) {
  for (char letter = 'A'; letter <= 'Z'; ++letter)
    if ((letters & letter_bit(letter)) != 0 && !use_optional(letter)) return false;
  return true;
}

/// Numbers without a point, where the control counts them in increments.
bool Control::settle_numbers() {
  const Block& b = *block_;
  if (profile_.numbers.integer_words == Profile::IntegerWords::units) return true;
  Letters dimensions = letters('X', 'Y', 'Z', 'I', 'J', 'K', 'R', 'A', 'B', 'C');
  const int motion = b.g_code(1) >= 0 ? b.g_code(1) : mode_;
  if (is_cycle(motion)) dimensions &= ~letter_bit('K');
  if (motion == 62) dimensions &= ~letters('K', 'R');  // knots and weights
  const Letters open = b.pointless & dimensions;
  if (open == 0) return true;
  if (profile_.numbers.integer_words == Profile::IntegerWords::ask) {
    for (char letter = 'A'; letter <= 'Z'; ++letter)
      if ((open & letter_bit(letter)) != 0)
        return refuse_at(letter, "E-DECIMAL", fmt::format("{} without a decimal point", letter),
                         "the control counts it in units or in increments, as a parameter says",
                         "say which with --integer-words, or post with points");
  }
  const int system = b.g_code(6);
  const bool inches = system >= 0 ? system == 200 : inch();
  const int decimals = inches ? profile_.numbers.decimals_inch : profile_.numbers.decimals_mm;
  settled_ = b;
  for (std::size_t i = 0; i < 26; ++i) {
    if ((open >> i & 1) == 0) continue;
    const bool plane = i >= 'I' - 'A' && i <= 'K' - 'A' && b.g_code(11) == 682;
    const bool angle = i < 3 || plane || (i == 'R' - 'A' && b.g_code(11) == 680);
    settled_.value[i] /= std::pow(10.0, angle ? profile_.numbers.decimals_degree : decimals);
  }
  block_ = &settled_;
  return true;
}

/// The T word: a number, or the name of a tool in the table.
bool Control::select_tool() {
  int number = 0;
  if (!use('T') || !whole_word('T', number, "E-TOOL")) return false;
  selected_ = number;
  Event& event = add(EventKind::tool, 0, letter_bit('T'));
  if (block_->tool_name.empty()) return true;
  event.text = block_->tool_name;
  for (const auto& [key, tool] : tools_)
    if (tool.comment.find(fmt::format("name=\"{}\"", block_->tool_name)) != std::string::npos) {
      selected_ = key;
      return true;
    }
  return refuse_at('T', "E-TOOL", fmt::format("no tool of the table has the name {}", block_->tool_name),
                   "the tool in the spindle is not known",
                   "put name=\"..\" behind ; in its line of the tool table");
}

/// The D word of controls whose tools have edges, and where the length then acts.
bool Control::edge() {
  using Edges = Profile::Tools::Edges;
  const Edges edges = profile_.tools.edges;
  if (edges != Edges::none && block_->has('D')) {
    const double d = (*block_)['D'];
    if (edges == Edges::tool && d != 0 && d != 1)
      return refuse_at('D', "E-TOOL", fmt::format("edge {:g} of a tool", d),
                       "the tool table holds one offset per tool", "use D1");
    if (!use('D') || !tool_offset(d == 0 ? 490 : 430)) return false;
    fill(events_[event_count_ - 1], EventKind::g_code, d == 0 ? 490 : 430, letter_bit('D'));
    events_[event_count_ - 1].sets_frames = true;
    edge_stated_ = true;
    edge_number_ = static_cast<int>(d);
  }
  if (profile_.tools.follows_plane && plane_ != 170 && frames_.tool_offset != Vec3::Zero())
    return refuse(1, "E-TOOL", "a tool offset in another plane than G17", "the length acts across that plane",
                  "write D0, or use G17");
  return true;
}

/// Frames of words: TRANS and ROT put an end to what was there, ATRANS and AROT add to it.
bool Control::make_frame(int code) {
  const Block& b = *block_;
  const bool shifts = code < 600, adds = code % 2 == 0;
  if (b.g_code(1) >= 0 || b.g_code(12) >= 0 || b.g_code(8) >= 0 || b.has('D') || b.tcp_code >= 0 ||
      (!shifts && (named_axes(b) != 0 || (b.words & letters('A', 'B', 'C')) != 0)))
    return refuse(b.g_column[0], "E-BLOCK", "a frame beside other codes", "their order is not defined",
                  "use two blocks");
  if (!adds) end_stretch();
  if (adds && frames_.turn != 0)
    return refuse(b.g_column[0], "E-ROTATION", "a further frame in a turned one",
                  "it would count in the turned axes", "write ROT or TRANS first");
  if (!use_all(shifts ? kAxisWords : letter_bit('R'))) return false;
  const bool turns = !shifts && b.has('R');
  if (turns && (plane_ != 170 || frames_.system().rotation != 0))
    return refuse(b.g_column[0], "E-ROTATION", "a turn outside G17 or in a turned work offset",
                  "its axis is not followed", "use G17 and an offset without rotation");
  const Vec3 zero = zero_of(frames_);
  if (!adds) frames_.g92 = Vec3::Zero();
  if (shifts)
    for (int i = 0; i < 3; ++i)
      if (const char letter = static_cast<char>('X' + i); b.has(letter))
        frames_.g92[i] += length_word(letter);
  if (!shifts || frames_.turn != 0) {
    frames_.turn = turns ? b['R'] * deg : 0;
    frames_.pivot = Vec3::Zero();
    constexpr Axes plane_xy = 3;
    m_.known &= ~plane_xy;
    m_.at[0] = m_.at[1] = 0;
  }
  u_ = program_of(frames_, m_);
  move_zero(zero);
  add(EventKind::g_code, code, shifts ? kAxisWords : letter_bit('R')).sets_frames = true;
  return true;
}

/// Notes the axes whose zero is no longer where it was.
void Control::move_zero(const Vec3& before) {
  constexpr double same = 1e-9;  // mm
  const Vec3 now = zero_of(frames_);
  for (int i = 0; i < 3; ++i)
    if (std::abs(now[i] - before[i]) > same) moved_zeros_ |= Axes{1} << i;
}

/// Whether the block's increments count from where the axes stand: some controls catch up with a moved zero.
bool Control::increments_sure() {
  if (profile_.offsets.increments_sure) return true;
  const Axes named = named_axes(*block_);
  const Axes distances = incremental_ ? named : named & block_->increments;
  if ((distances & moved_zeros_) != 0)
    return refuse(1, "E-POS", "an increment behind a shift of the zero of its axis",
                  "the control may catch up with the shift", "command the axis absolutely first");
  moved_zeros_ &= ~(named & ~distances);
  return true;
}

/// M98 P and M99, each alone in its block.
bool Control::change_flow(int code) {
  constexpr int call = 98, most = 9999;
  const Block& b = *block_;
  const Letters others = b.words & ~(code == call ? letters('N', 'P', 'L') : letter_bit('N'));
  const bool alone = others == 0 && b.g_groups == 0 && b.extra_count == 0 &&
                     (b.m_groups & ~(1u << Block::kStops)) == 0 && b.tcp_code < 0;
  if (!alone)
    return refuse(1, "E-OWORD", "a call or return beside other words", "the order is not defined",
                  "use two blocks");
  flow_ = -1;
  if (code != call) return true;
  if (!b.has('P') || !whole_word('P', flow_, "E-OWORD"))
    return refuse(1, "E-OWORD", "a call without the number P", "what runs is not known", "add P");
  if (flow_ < 1 || flow_ > most || (b.has('L') && b['L'] != 1))
    return refuse(1, "E-OWORD", "a call that repeats, or of no number from 1 to 9999",
                  "each run needs other corrections", "expand the calls");
  return true;
}

/// G68 X Y R, CYCL DEF 10 R and G69: after each, X and Y are known when the program commands them again.
void Control::turn(int code) {
  const Block& b = *block_;
  constexpr int ends = 690, at_datum = 692;
  frames_.turn = code != ends && b.has('R') ? b['R'] * deg : 0;
  frames_.pivot = Vec3(b.has('X') ? length_word('X') : 0, b.has('Y') ? length_word('Y') : 0, 0);
  const Letters words = code == ends ? 0 : code == at_datum ? letters('R') : letters('X', 'Y', 'R');
  pole_.reset();
  used_ |= words;
  constexpr Axes plane_xy = 3;
  m_.known &= ~plane_xy;
  m_.at[0] = m_.at[1] = 0;
  u_ = program_of(frames_, m_);
  add(EventKind::g_code, code, words).sets_frames = true;
}

}  // namespace abbe::verifying
