// How rotary axes go from end to end of a block under tool centre point control, where the program says
// (ORIMKS ORIWKS, ORIAXES ORIVECT): each evenly, or so that the tool turns in one plane.
#include <Eigen/Geometry>
#include <cmath>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

// Ways of a rotary axis that differ by less are one: the correction differs by far less than a digit, rad.
constexpr double kOneWay = 0.01 * deg;
constexpr int kLooks = 8;  // parts of the block
// Tool directions farther apart than this have no plane that is sure, rad.
constexpr double kOpposite = 170 * deg;
// Near the pole an axis turns far for a small tilt of the tool: rad of direction per rad.
constexpr double kLeastTilt = 0.02;
constexpr double kStep = 1e-4;  // rad, for that

}  // namespace

bool Rewriter::says_how_it_turns() const {
  return modal_.turn_codes.way != TurnCodes::Way::unsaid ||
         modal_.turn_codes.frame != TurnCodes::Frame::unsaid;
}

// A parameter says which of the two groups counts. Where both agree it does not matter.
bool Rewriter::turns_evenly() const {
  using Frame = TurnCodes::Frame;
  using Way = TurnCodes::Way;
  const auto [frame, way] = modal_.turn_codes;
  if (way == Way::axes && frame == Frame::machine) return true;
  const bool one_says_so = way == Way::axes || (way == Way::unsaid && frame != Frame::workpiece);
  return one_says_so && machine_.control.vectors.between == VectorRule::Between::axes;
}

// Are both ways one?  v(s) = (sin((1 - s) w) v0 + sin(s w) v1) / sin w,  w the angle between v0 and v1
bool Rewriter::evenly_enough(const Move& move) const {
  const Vec3 v0 = vectors_.vector_of(move.turns0), v1 = vectors_.vector_of(move.turns1);
  const double angle = std::atan2(v0.cross(v1).norm(), v0.dot(v1));
  if (!(angle < kOpposite)) return false;
  for (int i = 0; i <= kLooks; ++i) {
    const double s = static_cast<double>(i) / kLooks;
    Turns even = move.turns0;
    for (std::size_t k = 0; k < 3; ++k) even[k] += s * (move.turns1[k] - move.turns0[k]);
    for (std::size_t k = 0; k < 3; ++k) {
      if ((move.turning >> k & 1u) == 0) continue;
      Turns beside = even;
      beside[k] += kStep;
      if ((vectors_.vector_of(beside) - vectors_.vector_of(even)).norm() < kLeastTilt * kStep) return false;
    }
    const Vec3 v = std::sin((1 - s) * angle) * v0 + std::sin(s * angle) * v1;
    const ToolVectors::Answer flat = vectors_.turns_of(angle > 0 ? v : v0, even);
    if (flat.trouble != ToolVectors::Trouble::none) return false;
    for (std::size_t k = 0; k < 3; ++k)
      if (!(std::abs(flat.turns[k] - even[k]) <= kOneWay)) return false;
  }
  return true;
}

void Rewriter::judge_way(const Move& move) {
  if (!tcp_ || profile_.turns_evenly || turns_evenly() || evenly_enough(move)) return;
  if (says_how_it_turns())
    return refuse_block("E-TCP", "how the rotary axes go along this block is not sure",
                        "the control turns the tool in one plane, or each axis evenly, as its machine data "
                        "say: here that are "
                        "two ways",
                        "write ORIMKS and ORIAXES behind TRAORI; or ORIAXES, with vectors = { between = "
                        "\"axes\" } in [control] of "
                        "the machine file where the machine does so; or post shorter blocks");
  if (!way_said_)
    warn("W-ORI", "how the tool turns from end to end of the blocks is left to machine data",
         "each rotary axis is taken to go evenly; the control may turn the tool in one plane instead",
         "write ORIMKS and ORIAXES behind TRAORI, or state vectors = { between = \"axes\" } in [control]");
  way_said_ = true;
}

}  // namespace abbe
