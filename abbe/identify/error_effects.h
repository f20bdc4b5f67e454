#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/identify/model_term.h"

namespace abbe {

/// First-order effect of errors on the tip: deviation of the tool tip relative to the work, in workpiece
/// axes, per unit of an error. While only linear axes move it is affine in their positions,
///
///     effect(q) = c + G q,
///
/// found by asking the model itself (abbe/chain, first order) at zero and one unit along each axis, so every
/// convention of the machine file (branch, errors_seen, measured_at, order) holds here, too. Rotary axes
/// stand at 0.
///
/// laws     EffectEqualsPredictionOfAUnitError
/// cost     axes + 1 evaluations of the model per error when made; 9 multiplications per question
class ErrorEffects {
 public:
  ErrorEffects(const Machine& machine, const std::vector<ModelTerm>& terms);

  /// Of the error of term i, at the positions of `state`.
  [[nodiscard]] Vec3 of(std::size_t i, const AxisState& state) const;

  /// The nominal motion of the tip along the work per unit of moving axis `axis`; rotary axes: zero.
  [[nodiscard]] const Vec3& motion_of(int axis) const { return motion_[static_cast<std::size_t>(axis)]; }

 private:
  struct Affine {
    Vec3 constant = Vec3::Zero();
    std::vector<Vec3> gradient;  ///< per moving axis
  };
  std::vector<Affine> effects_;     ///< of distinct errors
  std::vector<std::size_t> which_;  ///< per term
  std::vector<Vec3> motion_;
};

}  // namespace abbe
