#pragma once

#include <cmath>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/chain/predict.h"
#include "abbe/core/units.h"
#include "abbe/machine/read_machine.h"

namespace abbe::test {

inline Machine machine_of(const std::string& text) {
  const auto read =
      read_machine({"machine.toml", text}, std::nullopt,
                   [](const std::string&) -> std::optional<std::string> { return std::nullopt; });
  if (!read.value)
    throw std::runtime_error(read.diagnostics.empty() ? "no machine" : to_text(read.diagnostics[0]));
  return *read.value;
}

struct Circle {
  TestPlane plane;
  double radius = 100, feed = 20;  ///< mm, mm/s
  int samples = 360;
  double from = 0, to = 360;  ///< deg, counter-clockwise
  std::string setup = {};
  bool clockwise = true;  ///< a second run back
  Vec3 centre = Vec3::Zero();
};

/// What a perfect ball bar shows of a machine: the distance of the actual tip from the actual tip at the
/// centre. Steady feed, samples between the steps of the angle, so that none is at a reversal.
inline BallbarTest measured(const Machine& machine, const Circle& circle, double noise = 0,
                            unsigned seed = 1) {
  const Plan plan = std::get<Plan>(make_plan(machine, {}));
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  BallbarTest test;
  test.plane = circle.plane;
  test.radius = circle.radius;
  test.feed = circle.feed;
  test.centre = circle.centre;
  test.setup = circle.setup;
  test.file = to_string(circle.plane) + std::to_string(static_cast<int>(circle.radius));
  const auto tip = [&](const Vec3& q, const Vec3& v, const Vec3& a) {
    Query query;
    query.tool = tool_of(machine);
    std::vector<double> velocity(static_cast<std::size_t>(machine.axis_count())), acceleration(velocity);
    for (int k = 0; k < 3; ++k) {
      const int axis = machine.find_axis(std::string(1, axis_letter(k)));
      if (axis < 0) continue;
      const auto i = static_cast<std::size_t>(axis);
      query.q[i] = q[k];
      velocity[i] = v[k];
      acceleration[i] = a[k];
      query.approach[i] = v[k] > 0 ? +1 : v[k] < 0 ? -1 : 0;
    }
    query.velocity = velocity;
    query.acceleration = acceleration;
    return actual_tip(plan, query);
  };
  const Vec3 centre = tip(circle.centre, Vec3::Zero(), Vec3::Zero());
  for (const int s : circle.clockwise ? std::vector{+1, -1} : std::vector{+1}) {
    BallbarRun run;
    run.direction = s;
    const double w = s * circle.feed / circle.radius;
    for (int i = 0; i < circle.samples; ++i) {
      const double part = (i + 0.5) / circle.samples;
      const double t = (circle.from + (s > 0 ? part : 1 - part) * (circle.to - circle.from)) * deg;
      const Vec3 u = radial_direction(circle.plane, t), along = radial_direction(circle.plane, t + 90 * deg);
      const Vec3 actual =
          tip(circle.centre + circle.radius * u, circle.radius * w * along, -circle.radius * w * w * u);
      run.angle.push_back(t);
      run.deviation.push_back((actual - centre).norm() - circle.radius + noise * normal(random));
    }
    test.runs.push_back(run);
  }
  if (noise > 0) test.noise = noise;
  return test;
}

}  // namespace abbe::test
