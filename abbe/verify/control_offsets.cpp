// Work offsets that a program sets (G10), positions that it declares (G92, G52), and reference positions.
#include <fmt/format.h>

#include <cmath>

#include "abbe/core/units.h"
#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

constexpr Letters kAxisLetters = letters('X', 'Y', 'Z');
constexpr Letters kTurnLetters = letters('A', 'B', 'C');

}  // namespace

bool Control::set_system() {
  const Block& b = *block_;
  int l = 0, p = 0;
  if (!b.has('L') || !b.has('P'))
    return refuse(b.g_column[0], "E-G10", "G10 without L and P", "what it sets is not known",
                  "give L2 or L20 and P");
  if (!use('L') || !use('P') || !whole_word('L', l, "E-G10") || !whole_word('P', p, "E-G10")) return false;
  // Where L20 does not read the position it sets a further offset.
  const bool further = l == 20 && !profile_.offsets.l20_reads;
  const int last = further ? profile_.offsets.further : profile_.offsets.fixed;
  if ((l != 2 && l != 20) || p > last || (p == 0 && (further || !profile_.offsets.p0_active)))
    return refuse_at(l != 2 && l != 20 ? 'L' : 'P', "E-G10",
                     fmt::format("G10 L{} P{} is not understood", l, p),
                     "only work offsets are followed: L2 and L20 with the P of one",
                     "set tools in the tool table, not in the program");
  if ((l == 2 || further) && incremental_)
    return refuse_at('L', "E-G10", "G10 L2 in G91", "controls disagree whether it adds to the offset",
                     "use G90");
  if (l == 20 && b.has('R'))
    return refuse_at('R', "E-G10", "R with G10 L20", "only L2 sets a rotation", "use G10 L2");
  for (const char letter : {'X', 'Y', 'Z', 'R'})
    if (!use_optional(letter)) return false;

  const int index = p == 0 ? frames_.active : further ? kFixedWorkOffsets - 1 + p : p - 1;
  Frames::System& system = frames_.systems[static_cast<std::size_t>(index)];
  const Axes named = named_axes(*block_);
  if (l == 2 || further) {
    for (int i = 0; i < 3; ++i)
      if ((named >> i & 1) != 0) system.origin[i] = length_word(static_cast<char>('X' + i));
    if (b.has('R')) system.rotation = b['R'] * deg;
  } else {
    constexpr Axes plane_xy = 3;
    const bool turned = system.rotation != 0 && (named & plane_xy) != 0;
    const Axes needed = turned ? named | plane_xy : named;
    if ((m_.known & needed) != needed)
      return refuse(b.g_column[0], "E-POS", "G10 L20 at a position that is not known",
                    "it stores the machine's position", "command the axis absolutely first");
    if (turned && (system.defined & plane_xy) != plane_xy)
      return refuse(b.g_column[0], "E-WCS", "G10 L20 on a rotated system whose origin is not known",
                    "the new origin depends on the old one", "give the work offset");
    // The reading p of system n, with the given axes replaced by v:  origin = m - tlo - Rz (p + g92)
    Vec3 reading =
        rotated_about_z(m_.at - system.origin - frames_.tool_offset, -system.rotation) - frames_.g92;
    for (int i = 0; i < 3; ++i)
      if ((named >> i & 1) != 0) reading[i] = length_word(static_cast<char>('X' + i));
    const Vec3 origin = m_.at - frames_.tool_offset - rotated_about_z(reading + frames_.g92, system.rotation);
    for (int i = 0; i < 3; ++i)
      if ((needed >> i & 1) != 0) system.origin[i] = origin[i];
  }
  system.defined |= named;
  u_ = program_of(frames_, m_);
  Event& event = add(EventKind::g_code, 100, letters('L', 'P', 'R') | kAxisLetters);
  event.sets_frames = true;
  event.sets_position = l == 20 && !further;
  return true;
}

bool Control::set_g92(int code) {
  const Block& b = *block_;
  const Axes named = named_axes(*block_);
  for (const char letter : {'X', 'Y', 'Z'})
    if (!use_optional(letter)) return false;
  if ((code == 920 || code == 520) && named == 0)
    return refuse(b.g_column[0], "E-G92", fmt::format("G{} without axis words", code / 10), "it sets nothing",
                  "name an axis");
  if (code == 920) {
    if (!frame_known()) return false;
    if ((u_.known & named) != named)
      return refuse(b.g_column[0], "E-POS", "G92 for an axis whose position is not known",
                    "the offset it makes depends on the position", "command the axis absolutely first");
  }
  switch (code) {
    case 920:  // g92 := u - v, so that p = u - g92 reads v
      for (int i = 0; i < 3; ++i)
        if ((named >> i & 1) != 0) frames_.g92[i] = u_.at[i] - length_word(static_cast<char>('X' + i));
      saved_g92_ = frames_.g92;
      break;
    case 520: {
      const Vec3 zero = zero_of(frames_);
      for (int i = 0; i < 3; ++i)
        if ((named >> i & 1) != 0) frames_.g92[i] = length_word(static_cast<char>('X' + i));
      saved_g92_ = frames_.g92;
      pole_.reset();
      move_zero(zero);
      break;
    }
    case 921:
      frames_.g92 = Vec3::Zero();
      saved_g92_.reset();
      break;
    case 922:
      frames_.g92 = Vec3::Zero();
      break;
    default:
      if (!saved_g92_)
        return refuse(b.g_column[0], "E-G92", "G92.3 restores an offset that this program did not set",
                      "the control's stored value is not known", "set the offset with G92");
      frames_.g92 = *saved_g92_;
      break;
  }
  Event& event = add(EventKind::g_code, code, kAxisLetters);
  event.sets_frames = true;
  event.sets_position = code == 920;
  return true;
}

void Control::go_home(int code) {
  moves_ = true;
  motion_.kind = MotionKind::home;
  motion_.code = profile_.text.conversational ? code + mode_ : code;  // L .. M91: at rapid or at a feed
  motion_.machine_words = motion_.to_hole = false;
  motion_.incremental = incremental_ || block_->increments != 0;
  motion_.named = named_axes(*block_);
  for (int i = 0; i < 3; ++i)
    motion_.words[i] = (motion_.named >> i & 1) != 0 ? length_word(static_cast<char>('X' + i)) : 0;
  motion_.tcp = tcp_;
  motion_.turns_start = motion_.turns_end = turns_;
  motion_.cutter = {};
  motion_.named_turns = 0;
  for (int k = 0; k < 3; ++k) {
    const char letter = static_cast<char>('A' + k);
    if (!block_->has(letter)) continue;
    motion_.named_turns |= Axes{1} << k;
    motion_.turn_words[static_cast<std::size_t>(k)] = (*block_)[letter];
  }
  motion_.start = m_;
  motion_.end = machine_of(frames_, led(*block_, u_));
  m_ = motion_.end;
  const bool all = motion_.named == 0 && (block_->words & kTurnLetters) == 0;
  m_.known &= all || tcp_ ? 0u : ~motion_.named;
  forget_turns();
  for (int i = 0; i < 3; ++i)
    if ((m_.known >> i & 1) == 0) m_.at[i] = 0;
  u_ = program_of(frames_, m_);
}

}  // namespace abbe::verifying
