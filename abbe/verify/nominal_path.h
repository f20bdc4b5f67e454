#pragma once

#include "abbe/verify/motion.h"
#include "abbe/verify/tip_model.h"

namespace abbe::verifying {

/// The path that a feed motion of the original program means: of the tool tip, in workpiece axes, mm:
///   P(s) = nominal(point(s)) + datum
/// and the question how far a tip is from it. Tips are asked for in the order in which they are cut, so
/// that closed arcs and several turns are followed by the angle swept.
class NominalPath {
 public:
  NominalPath(const TipModel& model, const Motion& motion, const Vec3& datum);

  /// The foot of a tip on the path.
  struct Foot {
    double s = 0;                   ///< not limited to [0, 1]
    Vec3 deviation = Vec3::Zero();  ///< tip - P(s)
    Vec3 across = Vec3::Zero();     ///< its part perpendicular to the path
  };
  [[nodiscard]] Foot foot(const Vec3& tip);

  /// The same at an s that is given, for arcs too small to measure angles on.
  [[nodiscard]] Foot foot_at(const Vec3& tip, double s) const;

  [[nodiscard]] Vec3 point(double s) const;                ///< P(s)
  [[nodiscard]] double length() const { return length_; }  ///< of the axis commands, mm

 private:
  const TipModel& model_;
  const Motion& motion_;
  Vec3 datum_;
  double length_ = 0;
  Vec3 start_ = Vec3::Zero(), direction_ = Vec3::Zero();  ///< lines: P(0) and P(1) - P(0)
  double inverse_square_ = 0;                             ///< 1 / |direction|^2, 0 for no motion
  double angle_ = 0, swept_ = 0;                          ///< arcs: of the last foot
};

}  // namespace abbe::verifying
