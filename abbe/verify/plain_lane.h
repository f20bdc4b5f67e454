#pragma once

#include "abbe/chain/turning_bend.h"
#include "abbe/verify/plain_motion.h"
#include "abbe/verify/tip_model.h"

namespace abbe::verifying {

/// What Comparison knows of runs of plain motions: one block of the output to each of the original.
struct PlainLane {
  /// How far an end of a motion is from what is meant.
  struct End {
    PlainMotion original, output;
    Vec3 meant = Vec3::Zero();         ///< nominal tip of the original, mm
    Vec3 miss = Vec3::Zero();          ///< of the output's tip, mm
    Vec3 before = Vec3::Zero();        ///< of the tip without compensation, mm
    double lean = 0, lean_before = 0;  ///< of the tool axes, rad
  };
  TurningBend bend;
  PlainRun original, output;
  TipModel::Poses meant, uncorrected, done;
  std::uint64_t original_serial = 0, output_serial = 0;
  bool follows = false;  ///< `last` is where both programs stand
  End last;
};

}  // namespace abbe::verifying
