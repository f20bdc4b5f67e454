// Plain blocks: where they lead, without executing them.
#include <cmath>

#include "abbe/core/units.h"
#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

constexpr double kSamePlace = 1e-12;  // rad, as of other blocks
constexpr Letters kPlainLetters = letters('X', 'Y', 'Z', 'A', 'B', 'C', 'F', 'N');
constexpr int kLine = 10, kMotionGroup = 1;

/// Words of axes, perhaps a number, a feed and G1, and nothing else on the line.
bool says_only_axes(const Block& block) {
  const bool only_line =
      block.g_groups == 0 || (block.g_groups == 1u << kMotionGroup && block.g_code(kMotionGroup) == kLine);
  return block.words != 0 && (block.words & ~kPlainLetters) == 0 && only_line && block.m_groups == 0 &&
         (block.comment_count | block.extra_count) == 0 && block.tcp_code < 0 && !block.deletable &&
         block.increments == 0 && block.pole == Block::Pole::none && block.pointless == 0;
}

}  // namespace

bool Control::goes_plainly() const {
  constexpr int per_minute = 940;
  return mode_ == kLine && feed_mode_ == per_minute && !incremental_ && !tcp_ && edge_stated_ &&
         (moved_zeros_ == 0 || profile_.offsets.increments_sure) && rotary_ != nullptr &&
         rotary_->declared() && unknown_turns_ == 0 && u_.known == kAllAxes && m_.known == kAllAxes &&
         frames_.system().defined == kAllAxes && frames_.turn == 0 && !frames_.placement.on() &&
         cutter_.phase == CutterUse::Phase::off && !drills_always_ && !ended_;
}

PlainMotion Control::here() const { return {u_.at, m_.at, turns_, feed_, false, false, 0, 0}; }

bool Control::leads_plainly(const Block& block, const PlainMotion& from, PlainMotion& to) const {
  if (!says_only_axes(block)) return false;
  to = from;
  to.named_turns = 0;
  for (int k = 0; k < 3; ++k) {
    const char letter = static_cast<char>('A' + k);
    if (!block.has(letter)) continue;
    if (!rotary_->goes_as_written(k)) return false;
    const auto i = static_cast<std::size_t>(k);
    const double place = block[letter] * deg + frames_.system().turns[i];
    if (std::abs(place - from.turns[i]) > kSamePlace) to.turns[i] = place;
    to.named_turns |= 1u << k;
  }
  const Position u = led(block, {from.u, kAllAxes});
  to.u = u.at;
  to.m = machine_of(frames_, u).at;
  to.states_feed = block.has('F');
  if (to.states_feed) to.feed = block['F'];
  to.states_number = block.has('N');
  to.number = to.states_number ? block['N'] : 0;
  return to.named_turns != 0 && to.feed > 0;
}

void Control::take(const PlainMotion& motion) {
  u_.at = motion.u;
  m_.at = motion.m;
  turns_ = motion.turns;
  feed_ = motion.feed;
  commanded_turns_ |= motion.named_turns;
  moves_ = false;
  event_count_ = after_count_ = 0;
}

}  // namespace abbe::verifying
