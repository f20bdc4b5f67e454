#include "abbe/verify/nominal_path.h"

#include <cmath>
#include <numbers>

namespace abbe::verifying {

NominalPath::NominalPath(const TipModel& model, const Motion& motion, const Vec3& datum)
    : model_(model), motion_(motion), datum_(datum), length_(length_of(motion)) {
  if (motion.kind == MotionKind::arc) {
    angle_ = motion.arc.start_angle;
    return;
  }
  start_ = model.nominal(motion.start.at) + datum;
  direction_ = model.nominal_step(motion.end.at - motion.start.at);
  const double square = direction_.squaredNorm();
  inverse_square_ = square > 0 ? 1 / square : 0;
}

Vec3 NominalPath::point(double s) const {
  if (motion_.kind != MotionKind::arc) return start_ + s * direction_;
  return model_.nominal(point_at(motion_, s)) + datum_;
}

NominalPath::Foot NominalPath::foot(const Vec3& tip) {
  if (motion_.kind != MotionKind::arc) {
    // s = (tip - P0) . (P1 - P0) / |P1 - P0|^2, so the deviation is already perpendicular
    Foot foot;
    foot.s = (tip - start_).dot(direction_) * inverse_square_;
    foot.deviation = foot.across = tip - start_ - foot.s * direction_;
    return foot;
  }
  // The angle about the centre in axis commands, unwrapped from the last foot's.
  const Arc& arc = motion_.arc;
  const Vec3 from_centre = model_.command_of(tip - datum_) - arc.centre;
  const double angle = std::atan2(from_centre.dot(arc.second), from_centre.dot(arc.first));
  swept_ += std::remainder(angle - angle_, 2 * std::numbers::pi);
  angle_ = angle;
  return foot_at(tip, swept_ / arc.sweep);
}

NominalPath::Foot NominalPath::foot_at(const Vec3& tip, double s) const {
  Foot foot;
  foot.s = s;
  foot.deviation = tip - point(s);
  const Vec3 tangent = model_.nominal_step(derivative_at(motion_, s));
  const double square = tangent.squaredNorm();
  foot.across =
      square > 0 ? Vec3(foot.deviation - tangent * (tangent.dot(foot.deviation) / square)) : foot.deviation;
  return foot;
}

}  // namespace abbe::verifying
