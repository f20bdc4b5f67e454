// What only conversational programs have: drilling cycles (CYCL DEF 200 .. 209, called by M99, CYCL CALL and
// M89), tools that the program describes, M126, M127 and M140.
#include <fmt/format.h>

#include <cmath>

#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

constexpr int kCallAlways = 89;

}  // namespace

/// A line of a definition: the control remembers it and does nothing.
bool Control::define_hole() {
  add_comments();
  if (block_->hole_begins) {
    if (drills_always_)
      return refuse(1, "E-CYCLE", "a definition while M89 calls a cycle behind every block",
                    "the control may go on calling", "end M89 by M99");
    hole_words_.cycle = block_->hole.cycle;
    hole_words_.count = 0;
  }
  if (hole_words_.cycle != block_->hole.cycle)
    return refuse(1, "E-CYCLE", "a line of a cycle that does not follow its first one",
                  "the control takes its lines together", "write all of them, from .0 on");
  for (int i = 0; i < block_->hole.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!hole_words_.take(block_->hole.name[k], block_->hole.value[k]))
      return refuse(1, "E-CYCLE", "a Q word twice in one cycle", "it is not defined which one holds",
                    "keep one");
  }
  return true;
}

/// TOOL DEF n L R: nothing happens as long as the table says the same.
bool Control::check_tool() {
  int number = 0;
  if (!whole_word('T', number, "E-TOOL")) return false;
  const auto entry = tools_.find(number);
  constexpr double same = 1e-9;  // mm
  if (entry == tools_.end())
    return refuse_at('T', "E-TOOL", fmt::format("TOOL DEF of tool {}, which is in no table", number),
                     "which length the control takes is not sure", "put it into the tool table");
  if (block_->has('L') && !(std::abs(length_word('L') - entry->second.offset[2]) <= same))
    return refuse_at('L', "E-TOOL", "TOOL DEF and the tool table differ in the length",
                     "which one the control takes is not sure", "make them the same");
  const auto given = radii_.find(number);
  const double diameter = entry->second.diameter;
  const double radius = given != radii_.end() ? given->second : diameter / 2;
  const bool known = given != radii_.end() || diameter != 0;
  if (block_->has('R') && known && !(std::abs(length_word('R') - radius) <= same))
    return refuse_at('R', "E-TOOL", "TOOL DEF and the tool table differ in the radius",
                     "which one the control takes is not sure", "make them the same");
  add_comments();
  return true;
}

/// M126 and M127 may only say how the rotary axes turn anyway.
bool Control::ways_agree() {
  const int code = block_->m_code(Block::kWays);
  if (code < 0 || rotary_ == nullptr) return true;
  const Turning said = code == 126 ? Turning::shortest : Turning::linear;
  for (int k = 0; k < 3; ++k)
    if (rotary_->has(k) && rotary_->turning(k) != said)
      return refuse(block_->m_column[Block::kWays], "E-ROTARY", "M126 or M127 against the machine file",
                    "the axis would turn the other way round", "state in [control] how it turns");
  return true;
}

/// M140: where the tool is along its axis is not known then.
bool Control::retract() {
  if (block_->m_code(Block::kRetracts) < 0) return true;
  if (motion_code_ >= 0 && (block_->words & (letters('X', 'Y', 'Z') | letters('A', 'B', 'C'))) != 0)
    return refuse(1, "E-MCODE", "M140 beside a motion", "their order is not sure", "use two blocks");
  bool turns = false;
  for (int k = 0; k < 3 && rotary_ != nullptr; ++k) turns = turns || rotary_->has(k);
  m_.known &= turns ? 0u : 3u;
  for (int i = 0; i < 3; ++i)
    if ((m_.known >> i & 1) == 0) m_.at[i] = 0;
  u_ = program_of(frames_, m_);
  return true;
}

/// What stands beside a call, or behind M89, must leave no doubt where the hole is.
bool Control::may_drill(int call) {
  const Block& b = *block_;
  const auto bad = [&](const char* code, const char* what, const char* why) {
    return refuse(1, code, what, why, "call each cycle behind a rapid to X.. Y..");
  };
  if (hole_words_.cycle == 0) return bad("E-CYCLE", "a call without a cycle", "the control has none to run");
  if (!profile_.text.conversational && !bracket_may_run()) return false;
  if (moves_ && motion_.kind != MotionKind::rapid && motion_.kind != MotionKind::line)
    return bad("E-CYCLE", "a call beside an arc or a move home", "where it drills is not sure");
  constexpr std::uint32_t calls = 1u << Block::kCalls;
  bool late = (b.m_after & ~calls) != 0;
  for (int i = 0; i < b.extra_count; ++i) late = late || b.extras[static_cast<std::size_t>(i)].after;
  if (late)
    return bad("E-AUX", "a call beside a code that acts behind the motion", "their order is not sure");
  const Placement::Kind kind = frames_.placement.kind;
  if (!profile_.text.conversational && frames_.placement.on())
    return bad("E-CYCLE", "a cycle in a tilted plane, scaled or mirrored", "its axis is not sure");
  const bool aside = hole_words_.cycle == 202 || hole_words_.cycle == 204;
  if (kind == Placement::Kind::scale || (kind == Placement::Kind::mirror && aside))
    return bad("E-CYCLE", "a cycle in a scaled frame, or a bore in a mirrored one",
               "what the control makes of its numbers is not sure");
  if (kind == Placement::Kind::plane && !on_plane_)
    return bad("E-CYCLE", "a cycle on a plane where the tool does not stand yet", "its axis is not sure");
  if (tcp_ && !on_plane_) return bad("E-TCP", "a cycle while the tip is controlled", "its axis is not sure");
  const bool always = drills_always_ || call != kOnceHere;
  const bool sideways = moves_ && motion_.kind == MotionKind::rapid && (motion_.named & 3u) != 0;
  if (always && !sideways)
    return bad("E-CYCLE", "M89 or MCALL beside another block than a rapid in X or Y",
               "it may drill there or not");
  return m_.known == kAllAxes
             ? frame_known()
             : bad("E-POS", "a cycle where an axis is not known", "the hole cannot be compared");
}

/// The cycle that the block calls, where its motion ends.
bool Control::drill() {
  const int call = block_->m_code(Block::kCalls);
  if (call < 0 && !(drills_always_ && moves_)) return true;
  if (!may_drill(call)) return false;
  drills_always_ = call == kCallAlways || (drills_always_ && call < 0);
  if (moves_) motion_.to_hole = motion_.kind == MotionKind::rapid;
  return run_hole();
}

/// The hole below where the tool stands.
bool Control::run_hole() {
  std::string fault;
  const auto place = place_of(hole_words_, fault);
  if (!place) return refuse(1, "E-CYCLE", fault, "where the tool goes is not sure", "complete the cycle");
  motion_.with_height = place->from_tool;
  drills_ = true;
  hole_ = Motion{};
  hole_.kind = MotionKind::cycle;
  constexpr int with_brackets = 1000;  // their numbers are those of G codes
  hole_.code = 10 * (hole_words_.cycle + (profile_.text.conversational ? 0 : with_brackets));
  hole_.start = m_;
  hole_.tcp = tcp_;
  hole_.turns_start = hole_.turns_end = turns_;
  hole_.feed_mode = feed_mode_;
  hole_.feed = feed_;
  const double zero = place->from_tool ? u_.at.z() : frames_.g92.z();
  const auto at_height = [&](double height) {
    Vec3 u = u_.at;
    u.z() = height * unit_ + zero;
    return Position{u, kAllAxes};
  };
  Cycle& cycle = hole_.cycle;
  cycle.lifted = cycle.travel = m_.at;
  cycle.retract = machine_of(frames_, at_height(place->retract)).at;
  cycle.bottom = machine_of(frames_, at_height(place->bottom)).at;
  u_ = at_height(place->clear);
  m_ = machine_of(frames_, u_);
  cycle.clear = m_.at;
  cycle.reach = place->reach * unit_;
  cycle.aside_axes = {vector_of(frames_, Vec3::UnitX()), vector_of(frames_, Vec3::UnitY())};
  cycle.words = &hole_words_;
  hole_.end = m_;
  return true;
}

}  // namespace abbe::verifying
