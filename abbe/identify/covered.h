#pragma once

#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/machine/machine.h"

namespace abbe {

/// What circular tests covered of one axis: positions (mm), the largest speed (mm/s) and acceleration
/// (mm/s^2).
struct Covered {
  double lo = 0, hi = 0, speed = 0, acceleration = 0;
};

/// Per moving axis of the machine, from the samples; all 0 where an axis did not move.
/// cost     one pass over the samples
[[nodiscard]] std::vector<Covered> covered_by(const Machine& machine, const std::vector<BallbarTest>& tests);

}  // namespace abbe
