// Drilling cycles with brackets: CYCLE81(..) where it stands, MCALL CYCLE81(..) behind every positioning
// block.
#include "abbe/verify/bracket_words.h"
#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

constexpr std::uint32_t kCycleGroup = 1u << 20;

}  // namespace

/// MCALL in this block.
bool Control::names_modal_call() const {
  for (int i = 0; i < block_->extra_count; ++i) {
    const Block::Extra& extra = block_->extras[static_cast<std::size_t>(i)];
    if (extra.kind == 'G' && profile_.g[static_cast<std::size_t>(extra.code)].meaning == Meaning::modal_call)
      return true;
  }
  return false;
}

bool Control::ends_modal_call() {
  constexpr int units = 6;
  if (drills_always_ && !profile_.text.conversational && block_->g_code(units) >= 0)
    return refuse(1, "E-CYCLE", "other units while MCALL calls a cycle", "its numbers may count in them",
                  "end MCALL before");
  if (!names_modal_call()) return true;
  if (motion_code_ >= 0)
    return refuse(1, "E-CYCLE", "MCALL beside a motion", "their order is not sure", "use two blocks");
  drills_always_ = false;
  return true;
}

/// The cycle of this block: run, or remembered.
bool Control::define_bracket() {
  const Block& b = *block_;
  const bool always = names_modal_call();
  const bool alone = (b.words & ~letter_bit('N')) == 0 && b.g_groups == kCycleGroup && b.m_groups == 0 &&
                     b.extra_count == (always ? 1 : 0) && b.tcp_code < 0;
  if (!alone)
    return refuse(1, "E-BLOCK", "a cycle beside other words", "their order is not sure", "use two blocks");
  if (drills_always_ && !always)
    return refuse(1, "E-CYCLE", "a cycle while MCALL calls one", "both may run", "end MCALL before");
  if (b.has('N')) add(EventKind::block_number, 0, letter_bit('N'));
  add_comments();
  hole_words_ = b.hole;
  std::string fault;
  if (!place_of(hole_words_, fault))
    return refuse(1, "E-CYCLE", fault, "where it drills is not sure", "correct it");
  drills_always_ = always;
  motion_code_ = -1;
  return always || (may_drill(kOnceHere) && run_hole());
}

/// Modes in which the cycle drills along Z, with its feed, where the block says.
bool Control::bracket_may_run() {
  constexpr int plane_xy = 170, inverse_time = 930;
  const auto bad = [&](const char* what) {
    return refuse(1, "E-CYCLE", what, "what the control makes of it is not followed",
                  "post the hole as G0 and G1");
  };
  if (plane_ != plane_xy) return bad("a cycle in another plane than G17");
  if (feed_mode_ == inverse_time) return bad("a cycle in inverse time");
  if (cutter_.phase != CutterUse::Phase::off) return bad("a cycle with cutter compensation");
  if (!edge_stated_) return bad("a cycle before D says which offset is in force");
  const bool elsewhere = moves_ && (motion_.machine_words || motion_.named_turns != 0);
  return !elsewhere || bad("a cycle behind a block of machine coordinates or rotary words");
}

}  // namespace abbe::verifying
