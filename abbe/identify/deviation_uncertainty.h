#pragma once

#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/identify/joint.h"
#include "abbe/machine/machine.h"

namespace abbe {

/// How well the static deviation is known in the box of tested positions.
struct DeviationUncertainty {
  std::vector<double> least, most;  ///< the box, per moving axis, mm; 0 to 0 where the tests move nothing
  std::vector<double> at;           ///< where it is worst, mm
  Vec3 u = Vec3::Zero();            ///< standard uncertainties there, along x y z of the workpiece, mm
  double worst = 0, rms = 0;        ///< of |u|, mm
};

/// With the covariance C of the terms, over a grid of 9 positions per tested axis, axes at rest and both
/// directions of approach averaged:
///
///     u^2(q) = diag(J C J^T),    J_k(q) = effect_k(q) basis_k(q),    |u|^2 = u_x^2 + u_y^2 + u_z^2 (1)
///
/// What was taken for zero has no part in it; centres and bar lengths have none in the deviation of a
/// machine.
///
/// laws     SquarenessTiltsTheBox, MoreSamplesLessUncertainty
/// cost     9^axes times the square of the number of terms
[[nodiscard]] DeviationUncertainty uncertainty_of_deviation(const Machine& machine,
                                                            const Identification& found,
                                                            const std::vector<BallbarTest>& tests);

}  // namespace abbe
