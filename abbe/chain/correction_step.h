#pragma once

#include <Eigen/QR>
#include <array>
#include <cmath>

#include "abbe/chain/correct.h"
#include "abbe/chain/walk.h"

namespace abbe {

/// What is left between tool and target: position in workpiece axes (mm) and the two components of the
/// tool axis across the target axis (rad).
struct Residual {
  Vec3 position = Vec3::Zero();
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();
};

/// Solves one step of the correction for a given set of free axes: rotary axes for the direction, then
/// linear axes for the position that remains (docs/theory/correction.md, equations 3 to 6).
class CorrectionStep {
 public:
  /// Which axis has to be held so that a step exists at all: two rotary axes that turn the tool about
  /// the same line. -1 = none.
  static constexpr int kNone = -1;

  /// columns  nominal derivatives at the command; a unit target axis
  void prepare(const Machine& machine, const CarriedColumns& columns, const Vec3& axis, AxisSet free,
               const std::array<double, kMaxAxes>& weights);

  /// dq of all axes (0 for those not free) that removes r; `left` is what it cannot remove.
  [[nodiscard]] std::array<double, kMaxAxes> solve(const Residual& r, Residual& left) const;

  [[nodiscard]] Eigen::Vector2d across(const Vec3& tool_axis) const { return basis_.transpose() * tool_axis; }
  [[nodiscard]] int singular_axis() const { return singular_axis_; }
  [[nodiscard]] int position_rank() const { return position_rank_; }
  [[nodiscard]] int linear_count() const { return linear_count_; }
  [[nodiscard]] bool redundant() const { return joint_; }
  [[nodiscard]] const std::array<int, kMaxAxes>& rotary() const { return rotary_; }
  [[nodiscard]] int rotary_count() const { return rotary_count_; }

 private:
  using PseudoInverse = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxAxes, 3>;
  using JointInverse = Eigen::Matrix<double, Eigen::Dynamic, 5, 0, kMaxAxes, 5>;

  void prepare_rotary(const std::array<double, kMaxAxes>& weights);
  void prepare_linear(const std::array<double, kMaxAxes>& weights);
  void prepare_joint(const std::array<double, kMaxAxes>& weights);

  Eigen::Matrix<double, 3, 2> basis_;  ///< of the plane across the target axis
  std::array<int, kMaxAxes> linear_{}, rotary_{};
  int linear_count_ = 0, rotary_count_ = 0;
  std::array<Vec3, kMaxAxes> position_;              ///< columns by axis
  std::array<Eigen::Vector2d, kMaxAxes> direction_;  ///< of rotary axes
  Eigen::Matrix2d rotary_inverse_ = Eigen::Matrix2d::Zero();
  Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMaxAxes, 2> rotary_pseudo_;  ///< more than two
  Mat3 linear_inverse_ = Mat3::Zero();
  PseudoInverse linear_pseudo_;
  JointInverse joint_inverse_;
  bool square_ = false;  ///< three independent linear axes
  bool joint_ = false;   ///< redundant axes, solved together
  int position_rank_ = 0;
  int singular_axis_ = kNone;
};

}  // namespace abbe
