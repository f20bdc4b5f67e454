// What controls differ in: codes without a group, numbers without a point, rotations made by the program.
#include <fmt/format.h>

#include <cmath>

#include "abbe/core/units.h"
#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

bool is_cycle(int code) { return code >= 730 && code != 800; }

}  // namespace

/// Codes without a group, before or after the motion.
bool Control::extras(bool after) {
  for (int i = 0; i < block_->extra_count; ++i) {
    const Block::Extra& extra = block_->extras[static_cast<std::size_t>(i)];
    if (extra.after != after) continue;
    if (!use_all(extra.words)) return false;
    const EventKind kind = extra.kind == 'G' ? EventKind::g_code : EventKind::m_code;
    if (after) {
      fill(after_[after_count_++], kind, extra.code, extra.words);
    } else {
      add(kind, extra.code, extra.words);
    }
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
  Letters dimensions = letters('X', 'Y', 'Z', 'I', 'J', 'K', 'R', 'A', 'B', 'C');
  const int motion = b.g_code(1) >= 0 ? b.g_code(1) : mode_;
  if (is_cycle(motion)) dimensions &= ~letter_bit('K');
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
    const bool angle = i < 3 || (i == 'R' - 'A' && b.g_code(11) == 680);
    settled_.value[i] /= std::pow(10.0, angle ? profile_.numbers.decimals_degree : decimals);
  }
  block_ = &settled_;
  return true;
}

/// G68 X Y R and G69: after either, X and Y are known when the program commands them again.
void Control::turn(int code) {
  const Block& b = *block_;
  frames_.turn = code == 680 && b.has('R') ? b['R'] * deg : 0;
  frames_.pivot = Vec3(b.has('X') ? length_word('X') : 0, b.has('Y') ? length_word('Y') : 0, 0);
  const Letters words = code == 680 ? letters('X', 'Y', 'R') : 0;
  used_ |= words;
  constexpr Axes plane_xy = 3;
  m_.known &= ~plane_xy;
  m_.at[0] = m_.at[1] = 0;
  u_ = program_of(frames_, m_);
  add(EventKind::g_code, code, words).sets_frames = true;
}

}  // namespace abbe::verifying
