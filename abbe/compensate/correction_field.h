#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "abbe/chain/correct.h"
#include "abbe/chain/bend.h"
#include "abbe/chain/plan.h"
#include "abbe/kernel/tip_function.h"

namespace abbe {

/// Where X Y Z of a three-axis program are among the moving axes of a machine.
struct ProgramAxes {
  std::array<int, 3> index{};
};

/// The linear axes addressed X, Y and Z. nullopt with the missing letter in `missing`.
[[nodiscard]] std::optional<ProgramAxes> program_axes(const Machine& machine, char& missing);

/// The correction as a function of the commanded position of a three-axis program:
///
///   q(m) solves  tip_actual(q) = tip_nominal(m) + D0                                       (2)
///
/// m, q   axis commands X Y Z, mm; the machine's other axes stand at 0
/// D0     the deviation at the origin of the work offset, for a probed datum, else 0
/// cost   about one model evaluation when asked along a path
/// source docs/theory/compensation.md
class CorrectionField {
 public:
  CorrectionField(const Plan& plan, const ProgramAxes& axes, bool probed);

  /// Tool in use and point of the datum; both change D0. False: D0 is not finite.
  void set_tool(const Tool& tool);
  void set_datum_point(const Vec3& m0);
  [[nodiscard]] const Vec3& datum() const { return options_.target_shift; }

  enum class Trouble { none, failed, outside, travel };
  struct Answer {
    Vec3 q = Vec3::Zero();
    Trouble trouble = Trouble::none;
    int axis = 0;  ///< of `travel`
  };
  /// `withheld`: bits 0 1 2 = X Y Z stay at their command. `approach`: -1 0 +1 per axis.
  [[nodiscard]] Answer at(const Vec3& m, unsigned withheld = 0, const std::array<signed char, 3>& approach = {});

  /// Positions of axis 0 1 2 between which the correction is close to quadratic, increasing, mm.
  [[nodiscard]] const std::vector<double>& knots(int axis) const { return knots_[static_cast<std::size_t>(axis)]; }
  [[nodiscard]] bool depends_on_direction() const { return directional_; }
  /// No straight move up to this length needs a look inside: between its ends the correction stays within
  /// `tolerance` of its chord, with the tool in use (abbe::straight_reach).
  [[nodiscard]] double straight_length(double tolerance) const { return straight_reach(plan_, tool_, tolerance); }

 private:
  void refresh_datum();
  [[nodiscard]] Query query(const Vec3& m) const;
  [[nodiscard]] int beyond_travel(const Vec3& m) const;
  [[nodiscard]] bool follow(const Vec3& m, const std::array<signed char, 3>& approach, Answer& answer);

  Plan plan_;
  kernel::TipFunction actual_tip_;
  ProgramAxes axes_;
  bool probed_;
  bool directional_ = false;
  Tool tool_;
  Vec3 datum_point_ = Vec3::Zero();
  std::array<AxisSet, 8> free_{};                   ///< by withheld bits
  std::array<std::optional<std::array<double, 2>>, 3> range_;
  std::array<std::array<double, 2>, 3> travel_{};   ///< the same, infinite where none is given
  Mat3 nominal_axes_ = Mat3::Identity(), inverse_axes_ = Mat3::Identity();
  Vec3 nominal_offset_ = Vec3::Zero();
  bool independent_ = false;                        ///< the three axes move the tip in every direction
  Query path_query_;                                ///< other axes at 0, the tool in use
  std::array<std::vector<double>, 3> knots_;
  CorrectOptions options_;
  Vec3 last_offset_ = Vec3::Zero();                 ///< correction found last: where the next search starts
};

}  // namespace abbe
