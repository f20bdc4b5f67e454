#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "abbe/chain/bend.h"
#include "abbe/chain/control_kinematics.h"
#include "abbe/chain/correct.h"
#include "abbe/chain/plan.h"
#include "abbe/chain/turning_bend.h"
#include "abbe/kernel/tip_function.h"

namespace abbe {

/// How the rotary axes stand while the linear ones move: where the original has them, and where the output
/// has put them (corrected and rounded), rad; and what the program's points mean.
struct Stance {
  Turns commanded{}, standing{};
  bool tcp = false;  ///< points are of the tip (equation 1 of ControlKinematics), not axis commands
};

/// The correction as a function of the programmed point, for rotary axes that stand still:
///
///   q(m) solves  tip_actual(q, standing) = tip_believed(m, commanded) + D0                 (2)
///
/// m, q   points in machine coordinates: axis commands X Y Z, or with TCP the tip's; mm
/// D0     the deviation at the origin of the work offset, for a probed datum, else 0; axes that no program
///        addresses stand at 0
/// cost   about one model evaluation when asked along a path
/// source docs/theory/compensation.md, docs/theory/five-axes.md
class CorrectionField {
 public:
  CorrectionField(const Plan& plan, const AddressedAxes& axes, bool probed);

  /// Tool in use and point of the datum; both change D0.
  void set_tool(const Tool& tool);
  void set_datum_point(const Vec3& m0);
  /// The length of the tool that the control reckons with (TCP), mm.
  void set_control_length(double length);
  /// False: the linear axes cannot follow points there.
  bool set_stance(const Stance& stance);
  [[nodiscard]] const Stance& stance() const { return stance_; }
  [[nodiscard]] const ControlKinematics& control() const { return control_; }
  [[nodiscard]] const Tool& tool() const { return tool_; }
  [[nodiscard]] const Vec3& datum() const { return datum_; }

  enum class Trouble { none, failed, outside, travel };
  struct Answer {
    Vec3 q = Vec3::Zero();
    Trouble trouble = Trouble::none;
    int axis = 0;   ///< of `travel`: 0 1 2 = X Y Z, 3 4 5 = A B C
    double at = 0;  ///< of `travel`: where the axis would go, mm or rad
  };
  /// `withheld`: bits 0 1 2 = X Y Z stay at their command (axis mode). `approach`: -1 0 +1 per axis.
  /// Answers for these points, one after the other, will soon be asked for: the first step towards each is
  /// made for all together. Other points may be asked for, too.
  void look_ahead(std::span<const Vec3> points, const std::array<signed char, 3>& approach);
  [[nodiscard]] Answer at(const Vec3& m, unsigned withheld = 0,
                          const std::array<signed char, 3>& approach = {});

  /// Corrected positions of the rotary axes in `turning` (bits 0 1 2 = A B C) for the point m of the
  /// original; the others stand as the present stance says. `held`: one was left at its command near a
  /// singularity.
  struct TurnsAnswer {
    Turns turns{};
    bool held = false;
    Trouble trouble = Trouble::none;
  };
  [[nodiscard]] TurnsAnswer turns_at(const Vec3& m, const Turns& commanded, unsigned turning);

  /// How far a tip commanded at q, in the present stance, is from where point m of the original means it to
  /// be: mm, and the angle between the tool axes, rad.
  struct Miss {
    double position = 0, direction = 0;
    bool outside = false;
  };
  [[nodiscard]] Miss miss(const Vec3& m, const Vec3& q) const;

  /// Axis commands of a point in the present stance, mm.
  [[nodiscard]] Vec3 commanded_axes(const Vec3& m) const { return stance_.tcp ? commanded_axes_(m) : m; }
  [[nodiscard]] Vec3 standing_axes(const Vec3& q) const { return stance_.tcp ? standing_axes_(q) : q; }
  /// The points of axis commands, by the same stance.
  [[nodiscard]] std::optional<Vec3> commanded_point(const Vec3& axes) const;
  [[nodiscard]] std::optional<Vec3> standing_point(const Vec3& axes) const;

  /// Positions of axis 0 1 2 between which the correction is close to quadratic, increasing, mm.
  [[nodiscard]] const std::vector<double>& knots(int axis) const {
    return knots_[static_cast<std::size_t>(axis)];
  }
  [[nodiscard]] bool depends_on_direction() const { return directional_; }
  /// No straight move up to this length needs a look inside: between its ends the correction stays within
  /// `tolerance` of its chord, with the tool in use (abbe::straight_reach).
  [[nodiscard]] double straight_length(double tolerance) const {
    return straight_reach(plan_, tool_, tolerance);
  }
  /// The same for moves along which rotary axes turn.
  [[nodiscard]] TurningBend turning_bend() const { return {plan_, tool_}; }

 private:
  void refresh();
  void refresh_datum();
  [[nodiscard]] Query query(const Vec3& axes, const Turns& turns) const;
  [[nodiscard]] double model_turn(std::size_t k, double turn) const;
  [[nodiscard]] int beyond_travel(const Vec3& axes) const;
  [[nodiscard]] std::optional<int> turn_beyond_travel(const Turns& turns) const;
  void approach_by(const std::array<signed char, 3>& approach);
  [[nodiscard]] kernel::TipAt tip_at(const Vec3& q);
  [[nodiscard]] const kernel::TipAt* begin(const Vec3& m, unsigned withheld,
                                           const std::array<signed char, 3>& approach, Vec3& q);
  [[nodiscard]] bool follow(const Vec3& m, const Mat3& inverse, const kernel::TipAt* begun, Answer& answer);
  [[nodiscard]] Mat3 inverse_without(unsigned withheld) const;

  Plan plan_;
  kernel::TipFunction actual_tip_;
  AddressedAxes axes_;
  ControlKinematics control_;
  bool probed_;
  bool directional_ = false;
  Tool tool_;
  double control_length_ = 0;
  Stance stance_;
  Vec3 datum_point_ = Vec3::Zero(), datum_ = Vec3::Zero();
  std::array<std::array<double, 2>, 3> travel_{}, turn_travel_{};  ///< infinite where none is given
  std::array<bool, 3> modulo_{};           ///< rotary axes whose positions repeat after a turn
  Affine nominal_;                         ///< point of the original -> its tip
  Affine commanded_axes_, standing_axes_;  ///< TCP: points -> axis commands
  Mat3 inverse_axes_ = Mat3::Identity();   ///< of the tip's motion by points
  bool independent_ = false;               ///< the three axes move the tip in every direction
  std::optional<int> turn_beyond_travel_;  ///< of the axes as they stand: 3 4 5 = A B C
  Query path_query_;                       ///< rotary axes as they stand, the tool in use
  std::array<std::vector<double>, 3> knots_;
  CorrectOptions turn_options_;
  Vec3 last_offset_ = Vec3::Zero();  ///< correction found last: where the next search starts
  /// Points looked ahead at, where their search starts, and the tips there.
  static constexpr std::size_t kAhead = kernel::TipFunction::kMost;
  std::array<Vec3, kAhead> ahead_, ahead_start_;
  std::array<kernel::TipAt, kAhead> ahead_tips_;
  std::size_t ahead_count_ = 0, ahead_next_ = 0;
  std::array<signed char, 3> ahead_approach_{};
  Vec3 ahead_offset_ = Vec3::Zero();  ///< last_offset_ when it was looked ahead last
};

}  // namespace abbe
