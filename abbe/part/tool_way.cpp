#include "abbe/part/tool_way.h"

#include <algorithm>

namespace abbe {

ToolWay::ToolWay(const Cutter& cutter, const Disturbance& disturbance, const PartBox& region)
    : cutter_(cutter), disturbance_(disturbance), region_(region), random_(disturbance.seed) {}

Vec3 ToolWay::draw() {
  if (disturbance_.noise == 0) return Vec3::Zero();
  const double x = random_.normal(), y = random_.normal(), z = random_.normal();
  return disturbance_.noise * Vec3(x, y, z);
}

/// By the ball about the tip that holds the whole cutter.
bool ToolWay::reaches(const SweepPiece& piece) const {
  const double far = cutter_.length + cutter_.radius + cutter_.corner;
  const Vec3 low = piece.from.tip.cwiseMin(piece.to.tip), high = piece.from.tip.cwiseMax(piece.to.tip);
  return ((low.array() - far <= region_.high.array()) && (high.array() + far >= region_.low.array())).all();
}

void ToolWay::add(const MotionPoses& motion) {
  if (!motion.connected) noise_ = draw();
  const Vec3 before = noise_;
  noise_ = draw();
  const double feed = motion.rapid ? 0 : motion.length;
  for (std::size_t k = 1; k < motion.poses.size(); ++k) {
    SweepPiece piece{motion.poses[k - 1], motion.poses[k], 0};
    piece.from.tip += before + motion.share[k - 1] * (noise_ - before);
    piece.to.tip += before + motion.share[k] * (noise_ - before);
    const double middle = (motion.share[k - 1] + motion.share[k]) / 2;
    piece.worn = disturbance_.worn + disturbance_.wear * (feed_ + middle * feed);
    if (!reaches(piece)) continue;
    full_ = full_ || pieces_.size() >= kMostPieces;
    if (!full_) pieces_.push_back(piece);
  }
  feed_ += feed;
}

}  // namespace abbe
