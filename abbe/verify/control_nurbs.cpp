// G6.2: every block has a knot, the first ones a control point each; the motion comes with the last knot.
#include <cmath>

#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

constexpr std::size_t kMostKnots = 100000;
constexpr double kOnStart = 1e-6;  // mm

}  // namespace

bool Control::nurbs_block() {
  const bool stated = block_->g_code(1) == 62;
  const auto refuse_it = [&](const char* message) {
    return refuse(1, "E-SPLINE", message, "the control stops, or makes another curve",
                  "correct the blocks of the curve");
  };
  if (stated == nurbs_open_)
    return refuse_it(stated ? "a curve inside a curve" : "a knot behind the end of its curve");
  if (frames_.placement.on() || tcp_)
    return refuse_it("a curve in a tilted, scaled or mirrored frame, or of the tip (G43.4, G43.5)");
  if (incremental_ || feed_mode_ == 930 || block_->deletable)
    return refuse_it("a curve in G91 or G93, or one that can be deleted");
  if (stated) {
    nurbs_ = Nurbs{};
    nurbs_.order = 4;
    if (block_->has('P') && (!use('P') || !whole_word('P', nurbs_.order, "E-SPLINE"))) return false;
    nurbs_at_ = u_;
    nurbs_axes_ = named_axes(*block_);
    nurbs_open_ = true;
  }
  if (!block_->has('K') || nurbs_.knots.size() == kMostKnots)
    return refuse_it("a block of a curve without K");
  if (!use('K')) return false;
  nurbs_.knots.push_back((*block_)['K']);
  if (named_axes(*block_) != 0 && !nurbs_point()) return false;
  const auto knots = nurbs_.points.size() + static_cast<std::size_t>(nurbs_.order);
  return nurbs_.knots.size() < knots || nurbs_.order < 2 || end_nurbs();
}

/// The control point of the block.
bool Control::nurbs_point() {
  if ((named_axes(*block_) & ~nurbs_axes_) != 0 || nurbs_.knots.size() != nurbs_.points.size() + 1)
    return refuse(1, "E-SPLINE", "a control point with a new axis, or behind the last ones",
                  "the control stops there", "correct the blocks of the curve");
  used_ |= letters('X', 'Y', 'Z');
  nurbs_at_ = led(*block_, nurbs_at_);
  const Position m = machine_of(frames_, nurbs_at_);
  if (m.known != kAllAxes)
    return refuse(1, "E-POS", "a control point that is not known in all axes", "its errors are not known",
                  "command all axes before");
  nurbs_.points.push_back(m.at);
  if (block_->has('R') && !use('R')) return false;
  nurbs_.weights.push_back(block_->has('R') ? (*block_)['R'] : 1);
  return true;
}

bool Control::end_nurbs() {
  nurbs_open_ = false;
  begin_motion(MotionKind::nurbs);
  if (!is_curve(nurbs_) || !((nurbs_.points.front() - m_.at).norm() <= kOnStart))
    return refuse(1, "E-SPLINE", "a curve that is not one, or does not begin where the tool stands",
                  "the control stops there", "correct points, knots and order");
  motion_.nurbs = &nurbs_;
  motion_.named = nurbs_axes_;
  u_ = nurbs_at_;
  m_ = machine_of(frames_, u_);
  motion_.end = m_;
  return true;
}

}  // namespace abbe::verifying
