#include "abbe/chain/effect.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "abbe/chain/plan_impl.h"
#include "abbe/chain/walk.h"

namespace abbe {
namespace {

constexpr int kPoses = 12;
constexpr double kNothing = 1e-10;  // of the unit's largest possible effect

[[nodiscard]] std::array<double, kMaxAxes> random_pose(const Machine& machine, std::mt19937& random) {
  // Drawn by hand: std distributions differ between libraries, the answer must not.
  const auto uniform = [&](double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(random()) / 4294967296.0);
  };
  std::array<double, kMaxAxes> q{};
  for (int i = 0; i < std::min(machine.axis_count(), kMaxAxes); ++i) {
    const Body& body = machine.axis(i);
    const double reach = body.type == AxisType::rotary ? std::numbers::pi : 500.0;
    const std::array<double, 2> range = body.range.value_or(std::array<double, 2>{-reach, reach});
    q[static_cast<std::size_t>(i)] = uniform(range[0], range[1]);
  }
  return q;
}

/// The largest lever in the machine: what a unit of rotation could move at most, roughly.
[[nodiscard]] double size_of(const Machine& machine, const Tool& tool) {
  double size = 1 + tool.tip.norm() + machine.workpiece_origin.norm();
  for (const Body& body : machine.bodies) {
    size += body.origin.norm();
    if (body.type != AxisType::linear) continue;
    size += body.range.has_value() ? std::max(std::abs((*body.range)[0]), std::abs((*body.range)[1])) : 500.0;
  }
  return size;
}

}  // namespace

std::vector<std::string> errors_without_effect(const Machine& machine) {
  auto unit = std::make_shared<Machine>(machine);
  for (ErrorTerm& error : unit->errors) {
    error.function = ErrorFunction::constant(1.0);
    error.scale = 1;
  }
  const Tool tool = tool_of(machine);
  const double size = size_of(machine, tool);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < machine.errors.size(); ++i) {
    const ErrorName& name = machine.errors[i].name;
    const Plan plan = compile_plan(unit, std::vector<double>(machine.variables.size(), 0.0),
                                   ErrorModel::first_order, static_cast<int>(i));
    const double limit = kNothing * (name.is_rotation() ? size : 1.0);
    std::mt19937 random(20260302);
    bool acts = false;
    for (int pose = 0; pose < kPoses && !acts; ++pose) {
      const std::array<double, kMaxAxes> q = random_pose(machine, random);
      Inputs<double> in;
      in.q = q.data();
      in.tip = tool.tip;
      CarriedTwist<double, 1> c;
      c.v[0] = tool.axis;
      bool outside = false;
      walk_first_order<double, 1>(plan.impl(), in, c, &outside);
      acts = !(c.dp.norm() <= limit && c.e.cross(c.v[0]).norm() <= kNothing);
    }
    std::string text = to_string(name);
    if (!acts && std::find(names.begin(), names.end(), text) == names.end()) names.push_back(std::move(text));
  }
  return names;
}

}  // namespace abbe
