#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/simulate/circle_run.h"
#include "command_line.h"
#include "session.h"

namespace abbe::app {

/// --test of identifiability and simulate ballbar, repeatable:
/// "plane=XY,radius=100,feed=2000" and optionally directions, from, to, overshoot (deg), acceleration
/// (mm/s^2), samples, noise (um), setup.
struct CirclePlan {
  PlannedCircle circle;
  double noise = 0;  ///< mm
};

void add_plan_option(Command& verb, std::vector<std::string>& plan);

/// All of them; nullopt after reporting every mistake.
[[nodiscard]] std::optional<std::vector<CirclePlan>> read_plan(const std::vector<std::string>& plan,
                                                               Session& session);

/// Angles of a plan, with deviations of 0: what identifiability asks about.
[[nodiscard]] BallbarTest unmeasured(const CirclePlan& plan);

/// "XY R100 mm, 2000 mm/min".
[[nodiscard]] std::string name_of(const PlannedCircle& circle);

}  // namespace abbe::app
