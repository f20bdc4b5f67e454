#include "abbe/chain/expanded_prediction.h"

namespace abbe {

Prediction expanded(Prediction prediction, const Pose& nominal, const WorkpieceExpansion& expansion) {
  if (!prediction.finite) return prediction;
  const Vec3 shift = -expansion.strain() * prediction.nominal.position;
  prediction.actual.position += shift;
  prediction.deviation.position += shift;
  prediction.tool_twist.d += nominal.R.transpose() * shift;
  return prediction;
}

}  // namespace abbe
