#pragma once

#include <array>
#include <optional>
#include <span>
#include <variant>

#include "abbe/chain/bend.h"
#include "abbe/chain/predict.h"
#include "abbe/core/diagnostic.h"
#include "abbe/kernel/tip_function.h"
#include "abbe/machine/control_setup.h"
#include "abbe/verify/frames.h"

namespace abbe::verifying {

using Approach = std::array<signed char, 3>;

/// The machine as programs of X Y Z see it: axis commands m (mm) to tool tips in workpiece axes (mm), all
/// other axes at 0, for the tool in the spindle.
class TipModel {
 public:
  /// errors   a diagnostic E-AXIS if X, Y or Z is missing, not linear, or not independent of the others
  [[nodiscard]] static std::variant<TipModel, Diagnostic> make(const Plan& plan, const ControlSetup& setup);

  /// Takes the gauge length of this tool (none: the machine file's).
  /// errors   a diagnostic E-TOOL if its length is a touch-off value and angular errors need a length
  [[nodiscard]] std::optional<Diagnostic> use_tool(std::optional<int> tool);

  /// tip = A m + b. Exact: three linear axes between constant bodies.
  [[nodiscard]] Vec3 nominal(const Vec3& m) const { return matrix_ * m + offset_; }
  [[nodiscard]] Vec3 nominal_step(const Vec3& step) const { return matrix_ * step; }
  [[nodiscard]] Vec3 command_of(const Vec3& tip) const { return inverse_ * (tip - offset_); }
  [[nodiscard]] Vec3 command_step(const Vec3& step) const { return inverse_ * step; }

  /// Tip with all errors. `outside` is set when an error is held beyond its ends.
  [[nodiscard]] Vec3 actual(const Vec3& m, const Approach& approach, bool* outside) const;

  /// Commands that actual() will probably be asked for soon, in this order: found together they cost less. Changes
  /// no answer by more than the rounding of doubles.
  void look_ahead(std::span<const Vec3> commands, const Approach& approach);

  /// See abbe::straight_reach; with the tool in the spindle.
  [[nodiscard]] double straight_reach(double bend) const {
    return abbe::straight_reach(plan_, query_.tool, bend);
  }

  /// The first axis whose travel m leaves, or -1.
  [[nodiscard]] int beyond_travel(const Vec3& m) const;

  [[nodiscard]] bool directional() const { return directional_; }

 private:
  TipModel(const Plan& plan, const ControlSetup& setup) : plan_(plan), actual_tip_(plan), setup_(setup) {}
  void place(const Approach& approach) const;

  static constexpr std::size_t kAhead = kernel::TipFunction::kMost;
  Plan plan_;
  kernel::TipFunction actual_tip_;
  ControlSetup setup_;
  std::array<std::size_t, 3> axes_{};  ///< of X Y Z among the moving axes
  mutable Query query_;
  // What look_ahead() found.
  std::array<Vec3, kAhead> ahead_;
  std::array<kernel::TipAt, kAhead> ahead_tips_;
  Approach ahead_approach_{};
  std::size_t ahead_count_ = 0;
  mutable std::size_t ahead_next_ = 0;
  Mat3 matrix_ = Mat3::Identity(), inverse_ = Mat3::Identity();
  Vec3 offset_ = Vec3::Zero();
  std::array<std::array<double, 2>, 3> travel_{};
  bool directional_ = false;
};

}  // namespace abbe::verifying
