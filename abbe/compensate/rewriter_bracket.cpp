// Drilling cycles of controls with names: CYCLE81(..) runs where it stands, MCALL CYCLE81(..) behind every
// positioning block. As a Klartext cycle it is shifted as a whole, along Z by the places in its brackets.

#include <algorithm>
#include <cmath>
#include <utility>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"

namespace abbe {

void Rewriter::define_bracket(std::string& out) {
  if (!bracket_allowed()) return;
  BracketAnswer answer = read_bracket_cycle(block_->brackets);
  if (!answer.cycle) {
    refuse_block("E-CYCLE", std::move(answer.message),
                 "where the hole is, or where the tool stands behind it, is not sure",
                 "write the cycle with literal RTP, RFP, SDIS and DP (or DPR), its modes zero or left out");
    return;
  }
  hole_ = Hole{};
  hole_.span = answer.cycle->span;
  hole_.sure = true;
  hole_.modal = block_->modal_call;
  hole_.surface_out = answer.cycle->surface();
  hole_.definition.cycle = answer.cycle->number;
  hole_.definition.words.push_back({kSurface, answer.cycle->surface(), answer.cycle->decimals(), {}});
  hole_.bracket = std::move(answer.cycle);
  if (!hole_.modal) return run_bracket(out);
  const auto offset = static_cast<std::size_t>(block_->brackets.data() - block_->text.data());
  held_from_ = out.size() - line_begin_ + offset;
  holds_ = depth_ == 0;
  pass(out);
}

// What stands in the block with the cycle. False: refused.
bool Rewriter::bracket_allowed() {
  if (block_->slash) {
    refuse_block("E-SKIP", "a cycle in a block with '/'",
                 "what runs behind it depends on the operator's switch", "write it without '/'");
    return false;
  }
  const auto other = [](const Word& word) { return word.letter != 'N'; };
  const auto words = std::count_if(block_->words.begin(), block_->words.begin() + block_->count, other);
  const Word& last = block_->words[static_cast<std::size_t>(block_->count - 1)];
  const bool cycle_last = block_->text.substr(last.begin).data() == block_->brackets.data();
  if (words != (block_->modal_call ? 2 : 1) || !cycle_last) {
    refuse_block("E-BLOCK", "a drilling cycle beside other words", "in which order they act is not sure",
                 "give it a block of its own");
    return false;
  }
  if (hole_.modal && !block_->modal_call) {
    refuse_block("E-CYCLE", "a cycle is called while MCALL calls one behind every block",
                 "whether the other one runs as well is not sure", "end it with MCALL before");
    return false;
  }
  return block_->modal_call || hole_allowed();
}

// The state in which a cycle runs. False: refused.
bool Rewriter::hole_allowed() {
  const auto bad = [&](const char* code, const char* what, const char* why, const char* fix) {
    refuse_block(code, what, why, fix);
    return false;
  };
  if (!modal_.stated || offset_doubtful_)
    return bad("E-START", "a cycle before units, G90 or G91, work offset and D are stated",
               "where it drills depends on what ran before", "write G710 G90 G54 D1 before");
  if (modal_.plane != Plane::xy || in_.frames.placed())
    return bad("E-CYCLE", "a cycle in another plane than G17, or in a scaled, mirrored or tilted frame",
               "its numbers are one height for all holes, which need their own",
               "post the holes as G0 and G1");
  if (tcp_)
    return bad("E-TCP", "a cycle is called while tool centre point control is on",
               "along which axis the control drills then is not sure", "write TRAFOOF before");
  if (modal_.feed_mode == 930 || cutter_.acts())
    return bad("E-CYCLE", "a cycle with inverse time feed, or with cutter compensation",
               "what the control makes of it is not followed", "write G94 and G40 before");
  return (withheld_ & 3U) == 0 || holds_withheld(in_.m, "a cycle");
}

// Does a motion, or its end, call the cycle of MCALL? False: refused.
bool Rewriter::call_bracket(bool moves) {
  drills_ = false;
  if (!hole_.modal && !instruction_.ends_call) return true;
  const auto bad = [&](const char* code, const char* what, const char* why, const char* fix) {
    refuse_block(code, what, why, fix);
    return false;
  };
  if (instruction_.ends_call) {
    if (moves)
      return bad("E-CYCLE", "MCALL beside a motion", "whether the cycle runs once more is not sure",
                 "give it a block of its own");
    hole_.modal = holds_ = false;
    return true;
  }
  if (instruction_.units >= 0)
    return bad("E-CYCLE", "other units while MCALL calls a cycle",
               "whether its numbers count in the new ones is not sure", "end it with MCALL before");
  if (!moves) return true;
  const bool to_hole = instruction_.motion == 0 && instruction_.zero < 0 && !instruction_.turns_axes &&
                       !instruction_.directs_tool && (axis_word(0) != nullptr || axis_word(1) != nullptr);
  if (!to_hole)
    return bad("E-CYCLE", "MCALL calls a cycle behind a block that is not G0 X.. Y..",
               "whether the control drills there is not sure",
               "end it with MCALL before, or go to holes with G0");
  for (int i = 0; i < block_->count; ++i)
    if (acts_after_motion(profile_, block_->words[static_cast<std::size_t>(i)]))
      return bad("E-AUX", "MCALL calls a cycle beside a code that acts behind the motion",
                 "whether it acts before or behind the cycle is not sure",
                 "give the code a block of its own");
  if (!hole_allowed()) return false;
  drills_ = true;
  return true;
}

// A cycle that runs where it stands: the block itself gets the numbers of its hole. Where the tool must step
// aside before, number and comment of the block go to that step, and the cycle follows alone.
void Rewriter::run_bracket(std::string& out) {
  const std::size_t step = out.size();
  holds_ = true;
  drill(out, step);
  holds_ = false;
  std::string cycle = held_surface_.empty() ? hole_.bracket->text : std::exchange(held_surface_, {});
  std::string text(block_->text);
  const auto offset = static_cast<std::size_t>(block_->brackets.data() - block_->text.data());
  const bool steps = out.size() > step;
  const std::string aside(without_eol(std::string_view(out).substr(step)));
  text.replace(offset, block_->brackets.size(), steps ? aside : cycle);
  if (text != block_->text) ++report_.blocks.rewritten;
  if (steps) {
    const std::string eol = out.substr(step + aside.size());
    out.replace(step, std::string::npos, text + eol);
    check_length(text.size());
    text = std::move(cycle);
  }
  const std::size_t begin = out.size();
  out += text;
  end_line(out, begin);
}

// The places of the output become those of the original plus the shift, program units.
void Rewriter::set_levels(double shift, std::string& before) {
  const BracketCycle& cycle = *hole_.bracket;
  const int decimals = std::max(decimals_of(nullptr), cycle.decimals());
  if (std::abs(cycle.surface() + shift - hole_.surface_out) > half_digit(decimals_of(nullptr))) {
    const double step = rounded(shift, decimals);
    std::string text = cycle.moved(step, decimals);
    check_length(text.size());
    hole_.surface_out = cycle.surface() + step;
    if (holds_) {
      held_surface_ = std::move(text);
      held_spelled_ = cycle.text.size();
    } else {
      before += "MCALL " + text;
      before += file_eol_.empty() ? std::string("\n") : file_eol_;
    }
  }
  holds_ = false;  // what follows needs it as it stands now
}

}  // namespace abbe
