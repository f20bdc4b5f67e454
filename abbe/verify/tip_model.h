#pragma once

#include <array>
#include <optional>
#include <span>
#include <variant>

#include "abbe/chain/bend.h"
#include "abbe/chain/predict.h"
#include "abbe/chain/turning_bend.h"
#include "abbe/core/diagnostic.h"
#include "abbe/kernel/tip_function.h"
#include "abbe/machine/control_setup.h"
#include "abbe/verify/frames.h"
#include "abbe/verify/plain_motion.h"
#include "abbe/verify/rotary.h"

namespace abbe::verifying {

using Approach = std::array<signed char, 3>;

/// How the rotary axes stand in the original and in the output, rad, and what positions mean.
struct Stance {
  Turns original{}, output{};
  bool tcp = false;
  double control_length = 0;  ///< tool length the control reckons with, mm
  friend bool operator==(const Stance&, const Stance&) = default;
};

/// The machine as programs see it: points m in machine coordinates (mm; axis commands, or with tool centre
/// point control the tip's) to tool tips in workpiece axes (mm), for the tool in the spindle and rotary axes
/// that stand as the stance says. Axes that no program addresses are at 0.
class TipModel {
 public:
  /// errors   a diagnostic E-AXIS if X, Y or Z is missing, not linear, or not independent of the others
  [[nodiscard]] static std::variant<TipModel, Diagnostic> make(const Plan& plan, const ControlSetup& setup);

  /// Takes the gauge length of this tool (none: the machine file's).
  /// errors   a diagnostic E-TOOL if its length is a touch-off value and angular errors need a length
  [[nodiscard]] std::optional<Diagnostic> use_tool(std::optional<int> tool);

  /// Forgets the stance before. False: the linear axes cannot follow points there.
  bool stand(const Stance& stance);
  [[nodiscard]] const Stance& stance() const { return stance_; }

  /// tip = A m + b, as the control believes. Exact: three linear axes between constant bodies.
  [[nodiscard]] Vec3 nominal(const Vec3& m) const { return matrix_ * m + offset_; }
  [[nodiscard]] Vec3 nominal_step(const Vec3& step) const { return matrix_ * step; }
  [[nodiscard]] Vec3 command_of(const Vec3& tip) const { return inverse_ * (tip - offset_); }
  [[nodiscard]] Vec3 command_step(const Vec3& step) const { return inverse_ * step; }

  /// Tip and tool axis that the original means at its point m, and those of the machine at the output's.
  [[nodiscard]] TipAndAxis nominal_pose(const Vec3& m) const;
  [[nodiscard]] TipAndAxis actual_pose(const Vec3& m, bool* outside) const;

  /// Tip with all errors. `outside` is set when an error is held beyond its ends.
  [[nodiscard]] Vec3 actual(const Vec3& m, const Approach& approach, bool* outside) const;

  /// Tips and tool axes of many plain motions' ends, side by side.
  struct Poses {
    static constexpr std::size_t kMost = 16;
    std::array<std::array<double, kMost>, 6> number{};
    std::array<unsigned char, kMost> lanes{};  ///< not 0: an error is held beyond its ends
    [[nodiscard]] TipAndAxis at(std::size_t i) const {
      return {Vec3(number[0][i], number[1][i], number[2][i]), Vec3(number[3][i], number[4][i], number[5][i])};
    }
  };
  /// What nominal_pose() and actual_pose() give for axis commands, whatever the stance is.
  /// errors   no_poses(): not for this machine
  /// cost     some 20 and 50 ns per motion, no allocation
  void nominal_poses(std::span<const PlainMotion> motions, Poses& poses) const;
  void actual_poses(std::span<const PlainMotion> motions, Poses& poses) const;
  [[nodiscard]] bool no_poses() const { return flat_ == nullptr || believed_ == nullptr || directional_; }
  /// Positions of the axes that move, rows[axis][at].
  template <class Rows>
  void place(const Vec3& m, const Turns& turns, Rows& rows, std::size_t at) const {
    for (std::size_t k = 0; k < 3; ++k) {
      rows[axes_[k]][at] = m[static_cast<Eigen::Index>(k)];
      if (rotary_.has(static_cast<int>(k)))
        rows[static_cast<std::size_t>(rotary_.axes().rotary[k])][at] = turns[k];
    }
  }
  [[nodiscard]] int axis_count() const { return plan_.machine().axis_count(); }
  /// See TurningBend; with the tool in the spindle.
  [[nodiscard]] TurningBend turning_bend() const { return {plan_, query_.tool}; }
  /// An axis is outside its travel there.
  [[nodiscard]] bool beyond_travel(const PlainMotion& motion) const;

  /// Commands that actual() will probably be asked for soon, in this order: found together they cost less.
  /// Changes no answer by more than the rounding of doubles.
  void look_ahead(std::span<const Vec3> commands, const Approach& approach);

  /// See abbe::straight_reach; with the tool in the spindle.
  [[nodiscard]] double straight_reach(double bend) const {
    return abbe::straight_reach(plan_, query_.tool, bend);
  }

  /// Axis commands of a point of the output.
  [[nodiscard]] Vec3 axes_of(const Vec3& m) const { return stance_.tcp ? output_axes_(m) : m; }
  [[nodiscard]] Vec3 original_axes_of(const Vec3& m) const { return stance_.tcp ? original_axes_(m) : m; }

  /// The first axis whose travel the output leaves at m, or -1: 0 1 2 = X Y Z, 3 4 5 = A B C. `at` is where.
  [[nodiscard]] int beyond_travel(const Vec3& m, double* at = nullptr) const;

  [[nodiscard]] bool directional() const { return directional_; }
  [[nodiscard]] const Rotary& rotary() const { return rotary_; }

 private:
  TipModel(const Plan& plan, const ControlSetup& setup)
      : plan_(plan),
        actual_tip_(plan),
        flat_(kernel::FlatPlan::make(plan)),
        setup_(setup),
        rotary_(plan.machine()),
        believed_(kernel::FlatPlan::make(
            std::get<Plan>(make_plan(rotary_.kinematics().believed(), Environment{})))) {}
  void find(const kernel::FlatPlan& plan, std::span<const PlainMotion> motions, Poses& poses) const;
  void refresh();
  void turn(Query& query, const Turns& turns) const;
  void place(const Approach& approach) const;

  static constexpr std::size_t kAhead = kernel::TipFunction::kMost;
  Plan plan_;
  kernel::TipFunction actual_tip_;
  std::shared_ptr<const kernel::FlatPlan> flat_;
  ControlSetup setup_;
  Rotary rotary_;
  std::shared_ptr<const kernel::FlatPlan> believed_;  ///< as the control knows the machine
  Stance stance_;
  Affine original_axes_, output_axes_;  ///< with tool centre point control: points -> axis commands
  std::array<std::size_t, 3> axes_{};   ///< of X Y Z among the moving axes
  mutable Query query_;
  // What look_ahead() found.
  std::array<Vec3, kAhead> ahead_;
  std::array<kernel::TipAt, kAhead> ahead_tips_;
  Approach ahead_approach_{};
  std::size_t ahead_count_ = 0;
  mutable std::size_t ahead_next_ = 0;
  Mat3 matrix_ = Mat3::Identity(), inverse_ = Mat3::Identity();
  Vec3 offset_ = Vec3::Zero();
  std::array<std::array<double, 2>, 3> travel_{}, turn_travel_{};
  bool directional_ = false;
};

}  // namespace abbe::verifying
