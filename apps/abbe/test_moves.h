#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/core/linear_algebra.h"
#include "abbe/machine/machine.h"

namespace abbe::app {

/// A short move of one axis and how the ideal tool moves over the workpiece: shows whether axis
/// directions in the machine file are those of the machine.
struct AxisMove {
  int axis = 0;
  double from = 0, to = 0;   ///< mm or rad
  Vec3 body = Vec3::Zero();  ///< bed axes: motion of the axis' own body (rotary: rotation vector, rad)
  Vec3 tip = Vec3::Zero();   ///< workpiece axes, mm: motion of the tool tip relative to the workpiece
};
[[nodiscard]] std::vector<AxisMove> axis_moves(const Plan& plan);

/// What shows one error of the machine file at the machine: a move, or a change of a sensor, and how the
/// tool then departs from the ideal motion. `tip` and `rotation` are the change between both ends of
/// actual - nominal, of the tool relative to the workpiece, in workpiece axes, due to this error alone.
struct ErrorTest {
  std::size_t error = 0;    ///< index in Machine::errors
  std::optional<int> axis;  ///< the axis that moves, or none
  std::optional<std::string>
      sensor;               ///< the sensor that changes, or none; neither: constant, seen by no move
  double from = 0, to = 0;  ///< mm or rad; sensors in the units of the machine file
  std::array<double, kMaxAxes> at{};  ///< where the other axes stand
  Vec3 tip = Vec3::Zero();            ///< mm
  Vec3 rotation = Vec3::Zero();       ///< rad
};
[[nodiscard]] std::vector<ErrorTest> error_tests(const Machine& machine, const Environment& environment,
                                                 ErrorModel model);

}  // namespace abbe::app
