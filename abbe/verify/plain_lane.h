#pragma once

#include <array>
#include <utility>

#include "abbe/chain/turning_bend.h"
#include "abbe/verify/plain_motion.h"
#include "abbe/verify/tip_model.h"

namespace abbe::verifying {

/// What Comparison knows of runs of plain motions: one block of the output to each of the original.
struct PlainLane {
  explicit PlainLane(TurningBend known) : bend(std::move(known)) {}

  static constexpr std::size_t kMost = TipModel::Poses::kMost;
  /// How far an end of a motion is from what is meant.
  struct End {
    const PlainMotion* original = nullptr;
    const PlainMotion* output = nullptr;
    Vec3 meant = Vec3::Zero();                       ///< nominal tip of the original, mm
    Vec3 miss = Vec3::Zero();                        ///< of the output's tip, mm
    Vec3 before = Vec3::Zero();                      ///< of the tip without compensation, mm
    double lean_square = 0, lean_before_square = 0;  ///< sines of angles between tool axes, squared
  };
  TurningBend bend;
  PlainRun original, output;
  TipModel::Poses meant, uncorrected, done;
  std::uint64_t original_serial = 0, output_serial = 0;
  bool follows = false;  ///< `last` is where both programs stand
  double quantum = 0;    ///< Comparison::quantum
  PlainMotion last_original, last_output;
  std::array<End, kMost + 1> ends;  ///< the first one is where the run begins
  MoveRun run;                      ///< between them
};

}  // namespace abbe::verifying
