#include "abbe/simulate/circle_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <variant>

#include "abbe/ballbar/circle.h"
#include "abbe/ballbar/diagnosis.h"
#include "abbe/core/units.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

Plan plan_of(const std::string& errors) {
  const auto read = read_machine(
      {"machine.toml", "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n" + errors}, std::nullopt,
      [](const std::string&) -> std::optional<std::string> { return std::nullopt; });
  return std::get<Plan>(make_plan(read.value.value(), {}));
}

PlannedCircle some_circle() {
  PlannedCircle circle;
  circle.radius = 100;
  circle.feed = 40;
  circle.acceleration = 200;
  circle.to = 2 * std::numbers::pi;
  circle.overshoot = 0.5;
  circle.samples = 720;
  return circle;
}

TEST(SimulateCircle, IdealMachineDrawsACircle) {
  const SimulatedCircle made = simulate_circle(plan_of(""), some_circle(), {});
  ASSERT_EQ(made.test.runs.size(), 2U);
  for (const BallbarRun& run : made.test.runs) {
    ASSERT_EQ(run.angle.size(), 720U);
    for (const double d : run.deviation) EXPECT_NEAR(d, 0, 1e-7);
  }
  EXPECT_GT(made.test.runs[0].angle.back(), made.test.runs[0].angle.front());
  EXPECT_LT(made.test.runs[1].angle.back(), made.test.runs[1].angle.front());
  // From rest to rest.
  const BusRecord& bus = made.bus[0];
  EXPECT_LT((bus.actual[1] - bus.actual[0]).norm(), 1e-3);
  EXPECT_NEAR((bus.actual[500] - bus.actual[499]).norm(), 0.04, 1e-4);
}

TEST(SimulateCircle, LagShrinksAndTurnsTheTrace) {
  SimulationSettings settings;
  settings.lag = {2e-3, 3e-3, 0};
  const SimulatedCircle made = simulate_circle(plan_of(""), some_circle(), settings);
  const Diagnosis d = diagnose(made.test, {{}, false, false});
  EXPECT_NEAR(d.find(DiagnosisTerm::Kind::servo_mismatch)->value, -1e-3, 2e-5);
  // -v^2 (tau_x^2 + tau_y^2) / (4 R)
  EXPECT_NEAR(d.find(DiagnosisTerm::Kind::radius)->value / um, -1600 * (4e-6 + 9e-6) / 400 * 1e3, 0.02);
}

TEST(SimulateCircle, ErrorsHaveTheirShapes) {
  const SimulatedCircle made = simulate_circle(plan_of(R"([errors]
EXX = { forward = { poly = [-2] }, backward = { poly = [2] } }
EC0Y = 20
DXX = { poly = [0, -0.05], of = "v.X" }
)"),
                                               some_circle(), {});
  const Diagnosis d = diagnose(made.test, {{}, false, false});
  EXPECT_NEAR(d.find(DiagnosisTerm::Kind::backlash, "X")->value / um, 4, 0.05);
  EXPECT_NEAR(d.find(DiagnosisTerm::Kind::squareness)->value / urad, 20, 0.1);
  EXPECT_NEAR(d.find(DiagnosisTerm::Kind::servo_mismatch)->value * 1e3, 0.05, 1e-3);
}

TEST(SimulateCircle, MountingAndBarAreOff) {
  SimulationSettings settings;
  settings.mounting = {5 * um, -3 * um, 0};
  settings.bar_length = 2 * um;
  const SimulatedCircle made = simulate_circle(plan_of(""), some_circle(), settings);
  const FittedCircle fit = least_squares_circle(made.test.runs[0].angle, made.test.runs[0].deviation);
  EXPECT_NEAR(fit.x / um, -5, 0.01);
  EXPECT_NEAR(fit.y / um, 3, 0.01);
  EXPECT_NEAR(fit.mean / um, -2, 0.01);
}

TEST(SimulateCircle, SameSeedSameTrace) {
  SimulationSettings settings;
  settings.noise = 0.1 * um;
  settings.clock_offset = 1e-3;
  settings.seed = 7;
  const Plan plan = plan_of("");
  const auto first = simulate_circle(plan, some_circle(), settings);
  EXPECT_EQ(first.test.runs[1].deviation,
            simulate_circle(plan, some_circle(), settings).test.runs[1].deviation);
  settings.seed = 8;
  EXPECT_NE(first.test.runs[1].deviation,
            simulate_circle(plan, some_circle(), settings).test.runs[1].deviation);
}

}  // namespace
}  // namespace abbe
