// Frames that a program makes of its coordinates: shifts, turns, scales, mirrors.

#include <fmt/format.h>

#include <cmath>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/units.h"

namespace abbe {

// Coordinates mean something else from here on: these axes are known when the program commands them again.
void Rewriter::forget(unsigned axes) {
  known_ &= ~axes;
  withheld_ &= ~axes;
  last_correction_.reset();
  start_corrected_ = false;
}

bool Rewriter::change_frame() {
  switch (instruction_.frame) {
    case FrameChange::none:
      return true;
    case FrameChange::plane:
      return tilt_plane();
    case FrameChange::tool_to_plane:
      return tool_to_plane(std::nullopt);
    case FrameChange::spatial_plane:
      return spatial_plane();
    case FrameChange::swivel_plane:
      return swivel_plane();
    case FrameChange::end_plane:
      return reset_plane();
    case FrameChange::end_turn:
      if (plane_ != PlaneStage::none) {
        end_plane();
        return true;
      }
      [[fallthrough]];
    case FrameChange::turn:
      return turn_frame();
    case FrameChange::scale:
      return scale_frame();
    case FrameChange::mirror:
      return mirror_frame(true);
    case FrameChange::datum_turn:
      return datum_turn();
    case FrameChange::datum_mirror:
      return datum_mirror();
    case FrameChange::datum_scale:
      return datum_scale();
  }
  return true;
}

void Rewriter::place(const Mat3& matrix, const Vec3& at) {
  for (auto* side : {&in_, &out_}) side->frames.place(matrix, at);
  drop_pole();
  forget(7);
}

// A factor as the control reads it: with a point as it stands, else counted as the profile says.
std::optional<double> Rewriter::scale_factor(const Word& word) {
  using Scale = Profile::Numbers::Scale;
  const Scale rule = profile_.numbers.scale_words;
  const bool point =
      block_->text.substr(word.number, static_cast<std::size_t>(word.end - word.number)).find('.') !=
      std::string_view::npos;
  if (!point && rule == Scale::ask) {
    refuse(word, "E-DECIMAL", "a scale factor without a decimal point",
           "this control counts it in thousandths or in hundred-thousandths, as a parameter says",
           "state numbers.scale_words in a profile of your own, or post the factor with a point");
    return std::nullopt;
  }
  const double factor = word.value * (point ? 1.0 : rule == Scale::thousandths ? 1e-3 : 1e-5);
  if (!(factor >= kSmallestScale && factor <= kLargestScale)) {
    refuse(word, "E-FRAME", fmt::format("a scale factor of {:g}", factor),
           fmt::format("factors from {:g} to {:g} are followed", kSmallestScale, kLargestScale).c_str(),
           "scale in the CAM system");
    return std::nullopt;
  }
  return factor;
}

// G51 X Y Z P:  M p + o = f (p - k) + k.
bool Rewriter::scale_frame() {
  const Word* p = instruction_.find(*block_, 'P');
  if (!may_place() || !axis_word(0) || !axis_word(1) || !axis_word(2) || !p || modal_.incremental) {
    refuse_block("E-FRAME", "a scale is followed with X, Y, Z and P, in G17 and G90, one frame at a time",
                 "about which point and in which axes the rest scales is not sure otherwise",
                 "write G17 G90 before, then G51 X.. Y.. Z.. P..");
    return false;
  }
  const auto factor = scale_factor(*p);
  if (!factor) return false;
  Vec3 centre;
  for (int k = 0; k < 3; ++k) centre[k] = axis_word(k)->value * modal_.unit();
  frame_kind_ = FrameChange::scale;
  place(*factor * Mat3::Identity(), (1 - *factor) * centre);
  return true;
}

// G50, and G50.1 with the axes that are mirrored no longer. Where nothing is in force they say nothing, and
// may stand anywhere.
bool Rewriter::end_stretch() {
  const bool scale = instruction_.ends_scale && frame_kind_ == FrameChange::scale;
  const bool mirror = instruction_.ends_mirror && frame_kind_ == FrameChange::mirror;
  if (!scale && !mirror) return true;
  const Instruction& in = instruction_;
  if (in.states_motion || in.zero >= 0 || in.wcs >= 0 || in.tool_length >= 0 || in.tcp >= 0 ||
      in.tool_change || in.set_tool || in.turns_axes || in.frame != FrameChange::none) {
    refuse_block("E-BLOCK", "a scale or mirror ends together with other codes or words",
                 "in which order the control takes them is not sure", "give it a block of its own");
    return false;
  }
  if (mirror) return mirror_frame(false);
  leave_place();
  return true;
}

// G51.1 X Y:  x becomes 2 k - x.
bool Rewriter::mirror_frame(bool on) {
  const bool begins = frame_kind_ != FrameChange::mirror;
  if ((begins && !may_place()) || !instruction_.moves_axes || modal_.incremental) {
    refuse_block("E-FRAME", "a mirror is followed with X, Y or both, in G17 and G90, one frame at a time",
                 "at which place the rest is mirrored is not sure otherwise",
                 "write G17 G90 before, then G51.1 X.. or Y..");
    return false;
  }
  Mat3 matrix = in_.frames.matrix();
  Vec3 at = mirror_at_;
  for (int k = 0; k < 2; ++k) {
    const Word* word = axis_word(k);
    if (!word) continue;
    matrix(k, k) = on ? -1 : 1;
    at[k] = on ? 2 * word->value * modal_.unit() : 0;
  }
  if (matrix == Mat3::Identity()) {
    leave_place();
    return true;
  }
  frame_kind_ = FrameChange::mirror;
  mirror_at_ = at;
  place(matrix, at);
  return true;
}

// SCALE and MIRROR replace what stands (alone they end it), ASCALE and AMIRROR come on top of a shift.
bool Rewriter::stretch_frame() {
  const GCode zero = instruction_.zero;
  const bool scales = zero == 683 || zero == 684, anew = zero == 683 || zero == 685;
  if (anew) {
    const Vec3 reading = in_.p();
    if (in_.frames.turned()) {
      for (auto* side : {&in_, &out_}) side->frames.turn(Vec3::Zero(), 0);
      forget(3);
    }
    if (in_.frames.placed()) leave_place();
    for (auto* side : {&in_, &out_}) side->frames.set_g92(Vec3::Zero());
    note_shift(reading, in_.frames.turn_offset());
  }
  if (!instruction_.moves_axes) return true;
  Vec3 factors = Vec3::Ones();
  bool good = may_place() && !modal_.incremental;
  for (int k = 0; k < 3; ++k) {
    const Word* word = axis_word(k);
    if (!word) continue;
    factors[k] = scales ? word->value : -1;
    good = good && (scales ? word->value >= kSmallestScale && word->value <= kLargestScale
                           : k < 2 && word->value == 0);
  }
  if (!good) {
    refuse_block("E-FRAME", "a scale or mirror in another frame, in G91, of Z, or with a factor out of range",
                 "in which order frames act, or what is meant, is not sure",
                 "write G17 G90, then SCALE X.. Y.. Z.. or MIRROR X0");
    return false;
  }
  frame_kind_ = scales ? FrameChange::scale : FrameChange::mirror;
  place(factors.asDiagonal(), Vec3::Zero());
  return true;
}

// A scale or mirror may begin here.
bool Rewriter::may_place() const {
  return !in_.frames.placed() && !in_.frames.turned() && !in_.frames.rotated() && !tcp_ &&
         modal_.plane == Plane::xy;
}

void Rewriter::leave_place() {
  for (auto* side : {&in_, &out_}) side->frames.place_nothing();
  frame_kind_ = FrameChange::none;
  mirror_at_.setZero();
  drop_pole();
  forget(7);
}

// TRANS and ROT replace what stands (alone they end it), ATRANS and AROT come on top: first the turn, then
// the shift.
bool Rewriter::make_frame() {
  const GCode zero = instruction_.zero;
  const bool turns = zero >= 681, anew = zero == 521 || zero == 681;
  const Word* angle = instruction_.find(*block_, 'R');
  if (angle != nullptr && (modal_.plane != Plane::xy || in_.frames.rotated() != in_.frames.turned())) {
    refuse_block("E-ROTATION", "a rotation out of G17 or in a rotated work offset",
                 "about which axis the rest turns is not followed",
                 "write G17; set the offset without rotation");
    return false;
  }
  const Vec3 reading = in_.p();
  for (auto* side : {&in_, &out_}) {
    Vec3 shift = anew ? Vec3::Zero() : side->frames.g92();
    for (int k = 0; k < 3; ++k) {
      if (const Word* word = turns ? nullptr : axis_word(k)) shift[k] += word->value * modal_.unit();
    }
    side->frames.set_g92(shift);
  }
  if (in_.frames.placed()) leave_place();
  if (turns || in_.frames.turned()) {
    for (auto* side : {&in_, &out_})
      side->frames.turn(Vec3::Zero(), angle != nullptr ? angle->value * deg : 0.0);
    forget(3);
  }
  note_shift(reading, in_.frames.turn_offset());
  last_correction_.reset();
  return true;
}

// G68 X.. Y.. R..: what X and Y mean changes. They are known again when the program commands both.
bool Rewriter::turn_frame() {
  const Word* x = axis_word(0);
  const Word* y = axis_word(1);
  const Word* r = instruction_.find(*block_, 'R');
  const bool on = instruction_.frame == FrameChange::turn;
  if (on && (!x || !y || !r || modal_.plane != Plane::xy || modal_.incremental || in_.frames.rotated() ||
             in_.frames.placed())) {
    refuse_block("E-ROTATION", "a rotation is followed with X, Y and R, in G17 and G90, one at a time",
                 "about which point the rest turns is not sure otherwise",
                 "write G69, then G17 G90 G68 X.. Y.. R..");
    return false;
  }
  const Vec3 centre = on ? Vec3(x->value * modal_.unit(), y->value * modal_.unit(), 0) : Vec3::Zero();
  turn_about(centre, on ? r->value * deg : 0.0);
  return true;
}

void Rewriter::turn_about(const Vec3& centre, double angle) {
  for (auto* side : {&in_, &out_}) side->frames.turn(centre, angle);
  drop_pole();
  forget(3);
}

}  // namespace abbe
