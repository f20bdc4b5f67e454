#pragma once

#include <vector>

#include "abbe/identify/joint.h"
#include "abbe/identify/joint_design.h"
#include "abbe/identify/time_offset.h"

namespace abbe {

/// Servo, static and dynamic part of every run and the dynamic share with its interval: from kDraws draws of
/// the unknowns (normal, with the covariance; the generator and its seed are fixed, so results repeat).
[[nodiscard]] std::vector<RunBalance> run_balances(const Identification& identification,
                                                   const JointDesign& design, const RunClocks& clocks);

inline constexpr int kDraws = 200;

}  // namespace abbe
