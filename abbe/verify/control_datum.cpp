// Frames that conversational programs make about their datum: CYCL DEF 10, 8, 26 and 11.
#include <fmt/format.h>

#include "abbe/core/units.h"
#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

constexpr double kLeastFactor = 0.01, kMostFactor = 100;

}  // namespace

/// Another datum, a machine position or a plane while the program's axes are turned.
bool Control::datum_allows() {
  const Block& b = *block_;
  const int once = b.g_code(0);
  if (!profile_.text.conversational || frames_.turn == 0 || (once < 0 && b.g_code(12) < 0)) return true;
  return refuse(1, "E-ROTATION", "another datum or a machine position while the axes are turned",
                "in which order they act is not defined", "end the turn with ROT+0 before");
}

/// CYCL DEF 10.1 ROT.
bool Control::turn_about_datum() {
  if (!block_->has('R') || frames_.placement.on() || tcp_ || plane_ != 170 || frames_.system().rotation != 0)
    return refuse(block_->g_column[11], "E-ROTATION", "a turn in another frame or in a turned preset",
                  "the order in which they act is not defined", "end the other frame");
  turn(692);
  return true;
}

/// CYCL DEF 8.1 X Y: their signs change; without an axis all signs are again what they were.
bool Control::mirror_at_datum() {
  constexpr Letters words = letters('X', 'Y');
  const Letters named = block_->words & words;
  if (!use_all(words)) return false;
  add(EventKind::g_code, 512, named).sets_frames = true;
  if (named == 0) {
    end_placement(Placement::Kind::mirror);
    return true;
  }
  if (!frame_is_bare(block_->g_column[11])) return false;
  Placement& placement = frames_.placement;
  placement.kind = Placement::Kind::mirror;
  for (std::size_t i = 0; i < 2; ++i)
    if ((named & letter_bit(static_cast<char>('X' + i))) != 0) placement.axes[i] = -placement.axes[i];
  forget_positions();
  return true;
}

/// CYCL DEF 26.1 X Y Z CCX CCY: away from the centre by a factor for each axis; 11.1 SCL: by one for all, of
/// which the profile says whether Z is one of them.
bool Control::scale_at_datum() {
  using ScaleAxes = Profile::Numbers::ScaleAxes;
  const Block& b = *block_;
  constexpr Letters words = letters('X', 'Y', 'Z', 'I', 'J', 'K', 'P');
  const bool one = b.has('P');
  if (!use_all(words)) return false;
  add(EventKind::g_code, 513, words).sets_frames = true;
  Vec3 factor = Vec3::Ones(), centre = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const char axis = static_cast<char>('X' + i), place = static_cast<char>('I' + i);
    if (one || b.has(axis)) factor[i] = one ? b['P'] : b[axis];
    if (b.has(place)) centre[i] = length_word(place);
    if (!(factor[i] >= kLeastFactor && factor[i] <= kMostFactor))
      return refuse(1, "E-FRAME", fmt::format("the scale factor {:g}", factor[i]),
                    "it is more likely a wrong unit", "scale in the CAM system");
  }
  const ScaleAxes axes = profile_.numbers.scale_axes;
  if (one && factor.x() != 1 && axes == ScaleAxes::ask)
    return refuse(1, "E-FRAME", "one factor for all axes", "a parameter says whether Z is scaled",
                  "use CYCL DEF 26, or state numbers.scale_axes in a profile");
  if (one && axes == ScaleAxes::plane) factor.z() = 1;
  Placement& placement = frames_.placement;
  const bool scaled = placement.kind == Placement::Kind::scale;
  if (!scaled && factor == Vec3::Ones()) return true;
  bool replaced = one == scaled_by_one_;
  for (std::size_t i = 0; i < 3 && !one; ++i)
    replaced = replaced && (placement.axes[i].norm() == 1 || b.has(static_cast<char>('X' + i)));
  if (scaled && !replaced)
    return refuse(1, "E-FRAME", "a further scale that leaves part of the first", "what is scaled is not sure",
                  "name every axis that is scaled, or end it first");
  end_placement(Placement::Kind::scale);
  if (factor == Vec3::Ones()) return true;
  if (!frame_is_bare(b.g_column[11])) return false;
  placement.kind = Placement::Kind::scale;
  placement.origin = centre - factor.cwiseProduct(centre);
  for (std::size_t i = 0; i < 3; ++i) placement.axes[i] *= factor[static_cast<Eigen::Index>(i)];
  scaled_by_one_ = one;
  forget_positions();
  return true;
}

}  // namespace abbe::verifying
