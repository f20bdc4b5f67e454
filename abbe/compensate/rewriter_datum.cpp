// Frames of conversational programs, about the datum in force: cycles 10 (rotation), 8 (mirror image), 11 and
// 26 (scaling). One at a time: in which order they act together depends on the control.

#include <fmt/format.h>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/units.h"

namespace abbe {

// p becomes Rz(R) p. X and Y are known again when the program commands both.
bool Rewriter::datum_turn() {
  const Word* angle = instruction_.find(*block_, 'R');
  const bool offset_turned = in_.frames.rotated() != in_.frames.turned();
  if (angle == nullptr || in_.frames.placed() || tcp_ || offset_turned || modal_.plane != Plane::xy) {
    refuse_block("E-ROTATION", "a rotation in another frame, or in a preset that is turned itself",
                 "in which order they act is not sure", "end the other frame before");
    return false;
  }
  turn_about(Vec3::Zero(), angle->value * deg);
  return true;
}

// x becomes -x, y becomes -y.
bool Rewriter::datum_mirror() {
  if (!instruction_.moves_axes) {
    if (frame_kind_ == FrameChange::mirror) leave_place();
    return true;
  }
  if (!may_place()) {
    refuse_block("E-FRAME", "a mirror image in another frame, or while one is in force",
                 "in which order they act, or which axes are mirrored then, is not sure",
                 "end the other one before (CYCL DEF 8.0, 8.1)");
    return false;
  }
  Mat3 matrix = Mat3::Identity();
  for (int k = 0; k < 2; ++k) {
    if (axis_word(k) != nullptr) matrix(k, k) = -1;
  }
  frame_kind_ = FrameChange::mirror;
  place(matrix, Vec3::Zero());
  return true;
}

// The factors of X, Y and Z that the block states; 1 where it states none. Nothing: refused.
std::optional<Vec3> Rewriter::stated_factors() {
  using ScaleAxes = Profile::Numbers::ScaleAxes;
  const Word* all = instruction_.find(*block_, 'P');
  Vec3 factors = Vec3::Ones();
  for (int k = 0; k < 3; ++k) {
    const Word* word = all != nullptr ? all : axis_word(k);
    if (word == nullptr) continue;
    if (!(word->value >= kSmallestScale && word->value <= kLargestScale)) {
      refuse(*word, "E-FRAME", fmt::format("a scale factor of {:g}", word->value),
             "it is more likely a wrong unit", "scale in the CAM system");
      return std::nullopt;
    }
    factors[k] = word->value;
  }
  if (all == nullptr || all->value == 1) return factors;
  if (profile_.numbers.scale_axes == ScaleAxes::ask) {
    refuse(*all, "E-FRAME", "one scale factor for all axes",
           "a parameter of the control says whether it scales Z, too",
           "write CYCL DEF 26 with a factor for each axis, or state numbers.scale_axes in a profile of your "
           "own");
    return std::nullopt;
  }
  if (profile_.numbers.scale_axes == ScaleAxes::plane) factors.z() = 1;
  return factors;
}

// p becomes f (p - c) + c, axis by axis.
bool Rewriter::datum_scale() {
  const auto factors = stated_factors();
  if (!factors) return false;
  const bool evenly = instruction_.find(*block_, 'P') != nullptr, goes_on = frame_kind_ == FrameChange::scale;
  if (!goes_on && *factors == Vec3::Ones()) return true;  // ends nothing
  const Vec3 present = in_.frames.matrix().diagonal();
  bool sure = goes_on ? evenly == scaled_evenly_ : may_place();
  Vec3 centre = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    sure = sure && (!goes_on || evenly || present[k] == 1 || axis_word(k) != nullptr);
    if (const Word* word = instruction_.find(*block_, "IJK"[k])) centre[k] = word->value * modal_.unit();
  }
  if (!sure) {
    refuse_block("E-FRAME", "a scale in another frame, or one that leaves part of the one before in force",
                 "in which order they act, or what is scaled then, is not sure",
                 "end the other one before; name every axis that is scaled");
    return false;
  }
  if (*factors == Vec3::Ones()) {
    leave_place();
    return true;
  }
  frame_kind_ = FrameChange::scale;
  scaled_evenly_ = evenly;
  place(factors->asDiagonal(), centre - factors->cwiseProduct(centre));
  return true;
}

}  // namespace abbe
