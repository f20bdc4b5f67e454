#pragma once

#include <array>
#include <string>
#include <variant>
#include <vector>

#include "abbe/fit/fit_job.h"

namespace abbe {

/// Where balls lie, and how the rotary axes stand when they are looked at.
struct BallPlan {
  std::vector<Vec3> places;                          ///< workpiece axes, mm
  std::array<std::vector<double>, kMaxAxes> angles;  ///< of every rotary axis, rad; empty: it stands at 0
};

/// Every ball at every combination of angles: the commands that hold the tip of the machine's tool in its
/// centre on the ideal machine, by one linear solution for the linear axes (the nominal tip is linear in
/// them). Readings are 0.
///
/// errors   text: fewer or more than three linear axes, or three that do not span space, or a command beyond
/// its travel laws     TipStaysInTheBall
[[nodiscard]] std::variant<FitPoints, std::string> plan_balls(const Machine& machine, const BallPlan& plan);

}  // namespace abbe
