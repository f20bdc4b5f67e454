#pragma once

#include "abbe/chain/predict.h"
#include "abbe/machine/expansion.h"

namespace abbe {

/// The prediction as the part will be when it has cooled to 20 degC: what is machined at p of a warm part is
/// at p / (1 + s) then, so to first order
///
///   actual, deviation   less s p,   p = nominal tip in workpiece axes from the workpiece's origin
///   displacement        less s R^T p,   R: ideal tool axes in workpiece axes
///
/// Directions stay. Whatever axes carry the tool or the workpiece, which with_expansion (the same as errors
/// of the chain, for corrections) does not take.
///
/// units    mm, rad; nominal: nominal_pose at the query of the prediction
/// errors   numbers that are not finite stay 0
/// laws     ExpandedPredictionAgreesWithTheChain, TurningTheToolDoesNotMatter
/// cost     one rotation
[[nodiscard]] Prediction expanded(Prediction prediction, const Pose& nominal,
                                  const WorkpieceExpansion& expansion);

/// Where a point of the drawing is on the warm part: (1 + s) p. What a machine is asked for so that p is
/// right when the part has cooled.
[[nodiscard]] inline Vec3 expanded(const Vec3& point, const WorkpieceExpansion& expansion) {
  return (1 + expansion.strain()) * point;
}

}  // namespace abbe
