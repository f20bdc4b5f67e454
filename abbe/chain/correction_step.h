#pragma once

#include <array>
#include <cmath>

#include "abbe/chain/correct.h"
#include "abbe/chain/pseudo_inverse.h"
#include "abbe/chain/walk.h"

namespace abbe {

using Vec2 = Eigen::Vector2d;

/// What is left between tool and target: position in workpiece axes (mm) and the two components of the
/// tool axis across the target axis (rad).
struct Residual {
  Vec3 position = Vec3::Zero();
  Vec2 direction = Vec2::Zero();
};

/// Solves one step of the correction for a given set of free axes: rotary axes for the direction, then
/// linear axes for the position that remains (docs/theory/correction.md, equations 3 to 6).
class CorrectionStep {
 public:
  static constexpr int kNone = -1;

  /// columns  nominal derivatives; `axis` the target tool axis, a unit vector
  void prepare(const Plan::Impl& plan, const CarriedColumns& columns, const Vec3& axis, AxisSet free,
               const std::array<double, kMaxAxes>& weights);

  /// dq of all axes (0 for those not free) that removes r; `left` is what it cannot remove.
  [[nodiscard]] std::array<double, kMaxAxes> solve(const Residual& r, Residual& left) const;

  /// Components of a tool axis in the plane across the target axis.
  [[nodiscard]] Vec2 across(const Vec3& tool_axis) const {
    return {first_.dot(tool_axis), second_.dot(tool_axis)};
  }
  /// Two rotary axes turn the tool about one line: this one should rest. kNone otherwise.
  [[nodiscard]] int singular_axis() const { return singular_axis_; }
  /// Independent directions in which the linear axes can move the tip.
  [[nodiscard]] int position_rank() const { return position_rank_; }
  /// Three linear axes that move the tip in two directions only: the answer depends on where the search
  /// begins.
  [[nodiscard]] bool dependent() const { return linear_count_ == 3 && position_rank_ < 3; }
  [[nodiscard]] bool redundant() const { return joint_ || linear_count_ > 3 || rotary_count_ > 2; }
  /// As many axes as equations: the solution removes the residual whatever the Jacobian.
  [[nodiscard]] bool square() const {
    return square_ && !joint_ && (rotary_count_ == 0 || rotary_count_ == 2);
  }
  [[nodiscard]] int rotary(int i) const { return rotary_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int rotary_count() const { return rotary_count_; }

 private:
  void prepare_rotary(const std::array<double, kMaxAxes>& weights);
  void prepare_linear(const std::array<double, kMaxAxes>& weights);
  void prepare_joint(const std::array<double, kMaxAxes>& weights);

  Vec3 first_ = Vec3::UnitX(), second_ = Vec3::UnitY();  ///< unit vectors across the target axis
  std::array<int, kMaxAxes> linear_, rotary_;
  int linear_count_ = 0, rotary_count_ = 0;
  std::array<Vec3, kMaxAxes> position_;   ///< columns by axis
  std::array<Vec2, kMaxAxes> direction_;  ///< of rotary axes
  std::array<Vec2, 2> rotary_rows_;       ///< inverse for one or two rotary axes
  std::array<Vec3, 3> linear_rows_;       ///< inverse for three independent linear axes
  SmallMatrix rotary_inverse_, linear_inverse_, joint_inverse_;  ///< all other cases
  bool square_ = false;                                          ///< three independent linear axes
  bool joint_ = false;                                           ///< redundant axes, solved together
  int position_rank_ = 0;
  int singular_axis_ = kNone;
};

}  // namespace abbe
