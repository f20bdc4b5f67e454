#pragma once

#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/identify/joint.h"
#include "abbe/machine/read_machine.h"
#include "abbe/simulate/circle_run.h"

// A machine whose errors are hidden from the identification, and plans to measure it.

namespace abbe::test {

inline const std::string kChain = R"(format = 1
[machine]
name = "hidden"
chain = "w b X Y Z t"
[tool]
origin = [0, 0, 0]
)";

inline const std::string kHiddenErrors = R"([errors]
EXX = [ { poly = [0, 0.02, -1e-4, 3e-7] }, { forward = { poly = [-1.5] }, backward = { poly = [1.5] } } ]
EYY = [ { poly = [0, 0.012, 5e-5] }, { forward = { poly = [-1.0] }, backward = { poly = [1.0] } } ]
EYX = { poly = [0, 0, 2e-4] }
EXY = { poly = [0, 0, -1e-4, 2e-7] }
EC0Y = -18
DXX = [ { poly = [0, -0.03], of = "v.X" }, { poly = [0, 0.004], of = "a.X" } ]
DYY = [ { poly = [0, -0.05], of = "v.Y" }, { poly = [0, -0.006], of = "a.Y" } ]
)";

inline Machine machine_of(const std::string& text) {
  const auto read =
      read_machine({"machine.toml", text}, std::nullopt,
                   [](const std::string&) -> std::optional<std::string> { return std::nullopt; });
  if (!read.value) throw std::runtime_error(to_text(read.diagnostics.at(0)));
  return *read.value;
}

inline PlannedCircle circle_of(double radius, double feed, int samples) {
  PlannedCircle circle;
  circle.radius = radius;
  circle.feed = feed;
  circle.acceleration = 500;
  circle.to = 2 * std::numbers::pi;
  circle.overshoot = std::numbers::pi / 4;
  circle.samples = samples;
  circle.setup = "one";
  return circle;
}

/// Two radii, three feeds, both directions.
inline std::vector<BallbarTest> measure(const Machine& machine, SimulationSettings settings, int samples) {
  const Plan plan = std::get<Plan>(make_plan(machine, {}));
  std::vector<BallbarTest> tests;
  settings.seed *= 100;
  for (const double radius : {100.0, 150.0}) {
    for (const double feed : {10.0, 40.0, 80.0}) {
      ++settings.seed;
      tests.push_back(simulate_circle(plan, circle_of(radius, feed, samples), settings).test);
    }
  }
  return tests;
}

inline SimulationSettings quiet() {
  SimulationSettings settings;
  settings.noise = 0.1 * um;
  settings.mounting = {4 * um, -7 * um, 0};
  settings.bar_length = 1.3 * um;
  return settings;
}

}  // namespace abbe::test
