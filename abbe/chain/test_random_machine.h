#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"

namespace abbe {

/// Machines that nobody would build, for the laws of the chain: random branches, directions, orders of
/// factors and errors. Test support.
struct RandomMachine {
  explicit RandomMachine(unsigned seed) : random(seed) {}

  [[nodiscard]] double uniform(double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(random()) / 4294967296.0);
  }
  [[nodiscard]] int below(int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); }
  [[nodiscard]] Vec3 vector(double reach) {
    return {uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach)};
  }
  [[nodiscard]] Vec3 unit() {
    for (;;) {
      const Vec3 v = vector(1);
      if (v.norm() > 0.2 && v.norm() < 1) return v.normalized();
    }
  }

  /// `linear` and `rotary` axes in random places of the chain, every error class on them; values of
  /// about `length` mm and `angle` rad, gentle functions of positions.
  [[nodiscard]] Machine make(int linear, int rotary, double length, double angle) {
    Machine machine;
    std::vector<Body> tool, work;
    std::vector<std::string> names = {"X", "Y", "Z", "U", "V", "W"};
    std::vector<std::string> turning = {"A", "B", "C"};
    std::vector<std::pair<std::string, AxisType>> axes;
    for (int i = 0; i < linear; ++i) axes.emplace_back(names[static_cast<std::size_t>(i)], AxisType::linear);
    for (int i = 0; i < rotary; ++i)
      axes.emplace_back(turning[static_cast<std::size_t>(i)], AxisType::rotary);
    axes.emplace_back("S", AxisType::fixed);
    for (std::size_t i = axes.size(); i > 1; --i)
      std::swap(axes[i - 1], axes[static_cast<std::size_t>(below(static_cast<int>(i)))]);
    int linear_seen = 0, rotary_seen = 0;
    for (const auto& [name, type] : axes) {
      Body body;
      body.name = name;
      body.type = type;
      body.branch = below(2) == 0 ? Branch::tool : Branch::workpiece;
      // Near the coordinate directions, so that three linear axes span space.
      const int turn = type == AxisType::linear ? linear_seen++ : rotary_seen++;
      body.direction = (Vec3(Vec3::Unit(turn % 3)) * (below(2) == 0 ? 1 : -1) + 0.3 * unit()).normalized();
      body.origin = vector(300);
      body.range = type == AxisType::rotary ? std::array<double, 2>{-4, 4} : std::array<double, 2>{-500, 500};
      body.order = random_order(type);
      body.errors_seen_at_tool = body.branch == Branch::workpiece && below(2) == 0;
      if (below(3) == 0) body.measured_at = vector(200);
      (body.branch == Branch::tool ? tool : work).push_back(body);
    }
    machine.bodies = work;
    machine.bodies.insert(machine.bodies.end(), tool.begin(), tool.end());
    for (std::size_t i = 0; i < machine.bodies.size(); ++i) {
      Body& body = machine.bodies[i];
      if (body.type == AxisType::fixed) continue;
      body.axis = static_cast<int>(machine.axes.size());
      machine.axes.push_back(static_cast<int>(i));
      machine.variables.push_back({Variable::Kind::position, body.name, body.axis});
    }
    machine.variables.push_back({Variable::Kind::sensor, "T1", -1});
    machine.tool.origin = vector(300);
    machine.tool.axis = unit();
    machine.tool.length = uniform(0, 200);
    machine.workpiece_origin = vector(300);
    for (int i = 0; i < static_cast<int>(machine.bodies.size()); ++i) {
      for (const ErrorClass c :
           {ErrorClass::location, ErrorClass::thermal, ErrorClass::component, ErrorClass::dynamic}) {
        for (int direction = 0; direction < 6; ++direction)
          add_error(machine, i, c, direction, length, angle);
      }
    }
    for (const int mount : {kToolBody, kWorkpieceBody}) {
      for (int direction = 0; direction < 6; ++direction)
        add_error(machine, mount, ErrorClass::component, direction, length, angle);
    }
    return machine;
  }

  [[nodiscard]] Query query(const Machine& machine, double linear = 300, double rotary = 2) {
    Query query;
    query.tool = tool_of(machine);
    for (int i = 0; i < machine.axis_count(); ++i) {
      const double reach = machine.axis(i).type == AxisType::rotary ? rotary : linear;
      query.q[static_cast<std::size_t>(i)] = uniform(-reach, reach);
      query.approach[static_cast<std::size_t>(i)] = static_cast<signed char>(below(3) - 1);
    }
    return query;
  }

  std::mt19937 random;

 private:
  [[nodiscard]] std::vector<Factor> random_order(AxisType type) {
    switch (below(4)) {
      case 0:
        return type == AxisType::fixed ? without_motion(frame_order()) : line_order();
      case 1:
        return type == AxisType::fixed ? without_motion(frame_order()) : frame_order();
      case 2:
        return type == AxisType::fixed ? without_motion(after_order()) : after_order();
      default:
        break;
    }
    std::vector<Factor> order = {{FactorKind::location, false},
                                 {FactorKind::thermal, below(2) == 0},
                                 {FactorKind::component, below(2) == 0},
                                 {FactorKind::dynamic, false},
                                 {FactorKind::across, true},
                                 {FactorKind::along, false},
                                 {FactorKind::motion, false}};
    if (type == AxisType::fixed) order.pop_back();
    for (std::size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[static_cast<std::size_t>(below(static_cast<int>(i)))]);
    return order;
  }

  [[nodiscard]] static std::vector<Factor> without_motion(std::vector<Factor> order) {
    order.erase(std::remove_if(order.begin(), order.end(),
                               [](const Factor& f) { return f.kind == FactorKind::motion; }),
                order.end());
    return order;
  }

  void add_error(Machine& machine, int body, ErrorClass error_class, int direction, double length,
                 double angle) {
    if (below(4) == 0) return;
    ErrorTerm error;
    error.name.error_class = error_class;
    error.name.direction = direction;
    error.name.axis = body == kToolBody        ? "t"
                      : body == kWorkpieceBody ? "w"
                                               : machine.bodies[static_cast<std::size_t>(body)].name;
    error.body = body;
    error.scale = direction < 3 ? length : angle;
    error.function =
        function(machine, error_class == ErrorClass::location ? -1 : below(machine.axis_count() + 1));
    machine.errors.push_back(error);
  }

  /// Of order one; the variable -1 stands for a constant, one past the axes for the sensor.
  [[nodiscard]] ErrorFunction function(const Machine& machine, int variable) {
    if (variable < 0) return below(4) == 0 ? function(machine, 0) : ErrorFunction::constant(uniform(-1, 1));
    const bool angle = variable < machine.axis_count() && machine.axis(variable).type == AxisType::rotary;
    const double reach = angle ? 200.0 : 400.0;  // deg, mm; the sensor around 20
    switch (below(6)) {
      case 0:
        return *ErrorFunction::sine(variable, uniform(-1, 1), uniform(0.2, 1.5) * 3 / reach, uniform(-3, 3));
      case 1: {
        std::vector<double> x, y;
        for (int i = 0; i <= 12; ++i) {
          x.push_back(-reach * 2 + i * reach / 3 + uniform(-3, 3));
          y.push_back(uniform(-1, 1));
        }
        return *ErrorFunction::table(variable, x, y, ErrorFunction::Interpolation::cubic);
      }
      case 2:
        return ErrorFunction::directional(
            variable < machine.axis_count() ? variable : 0, ErrorFunction::constant(uniform(-1, 1)),
            *ErrorFunction::polynomial(variable, {uniform(-1, 1), uniform(-1, 1) / reach}));
      case 3:
        return ErrorFunction::product(
            {*ErrorFunction::polynomial(variable, {0.3, uniform(-1, 1) / reach}),
             *ErrorFunction::polynomial(machine.axis_count(), {0, 0.05}, uniform(-5, 5))});
      default:
        return *ErrorFunction::polynomial(
            variable, {uniform(-1, 1), uniform(-1, 1) / reach, uniform(-1, 1) / (reach * reach)},
            uniform(-20, 20));
    }
  }
};

}  // namespace abbe
