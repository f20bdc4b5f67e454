#include "test_moves.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <variant>

#include "abbe/chain/predict.h"
#include "abbe/core/units.h"

namespace abbe::app {
namespace {

constexpr double kLinearJog = 10 * mm;
constexpr double kRotaryJog = 10 * deg;
constexpr double kNoTravel = 100 * mm;  ///< to both sides, where no travel is stated
constexpr double kMostSteps = 24;       ///< positions tried along an axis
constexpr double kGoodEnough = 0.7;     ///< the shortest move that shows this part of the largest change
constexpr double kOwnAxisEnough = 0.2;  ///< the error's own axis is preferred unless it shows much less
constexpr double kNothing = 1e-3 * um;  ///< changes below this (mm, or rad times a metre) are no signal
constexpr double kLever = 1000 * mm;    ///< weighs rotations against displacements

/// Deviation of the tool relative to the workpiece in workpiece axes.
struct Departure {
  Vec3 tip = Vec3::Zero(), rotation = Vec3::Zero();
};

Departure departure(const Plan& plan, const Query& query) {
  const Prediction prediction = predict(plan, query);
  // The twist is in the axes of the ideal tool: e_w = R_nominal e.
  return {prediction.deviation.position, nominal_pose(plan, query).R * prediction.tool_twist.e};
}

std::array<double, 2> travel_of(const Body& axis) {
  if (axis.range) return *axis.range;
  if (axis.type == AxisType::rotary) return {0, 2 * std::numbers::pi};
  return {-kNoTravel, kNoTravel};
}

/// Zero, or the end of the travel nearest to it.
std::array<double, kMaxAxes> home(const Machine& machine) {
  std::array<double, kMaxAxes> q{};
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (const auto& range = machine.axis(i).range)
      q[static_cast<std::size_t>(i)] = std::clamp(0.0, (*range)[0], (*range)[1]);
  }
  return q;
}

/// Round positions over the travel: multiples of 1, 2 or 5 times a power of ten of the unit people jog in,
/// or of 15 degrees.
std::vector<double> round_positions(const Body& axis) {
  const bool rotary = axis.type == AxisType::rotary;
  const double unit = rotary ? deg : mm;
  const auto [lo, hi] = travel_of(axis);
  const double least = (hi - lo) / unit / kMostSteps;
  std::vector<double> positions;
  if (!(least > 0)) return {lo};
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= least) step = factor * power;
  }
  // A full turn in steps that meet its quarters.
  if (rotary && least > 10) step = 15;
  const double first = std::ceil(lo / unit / step - 1e-9), last = std::floor(hi / unit / step + 1e-9);
  for (double k = first; k <= last; ++k) positions.push_back(k * step * unit);
  return positions;
}

double size_of(const Departure& change, bool rotation) {
  return rotation ? change.rotation.norm() * kLever : change.tip.norm();
}

Departure difference(const Departure& a, const Departure& b) {
  return {b.tip - a.tip, b.rotation - a.rotation};
}

/// The shortest move among round positions that shows most of what this axis can show.
struct Candidate {
  double from = 0, to = 0, size = 0;
  Departure change;
};
Candidate best_move(const Plan& plan, Query query, int axis, bool rotation) {
  const std::vector<double> positions = round_positions(plan.machine().axis(axis));
  std::vector<Departure> seen;
  for (const double position : positions) {
    query.q[static_cast<std::size_t>(axis)] = position;
    seen.push_back(departure(plan, query));
  }
  double largest = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    for (std::size_t k = i + 1; k < seen.size(); ++k) {
      largest = std::max(largest, size_of(difference(seen[i], seen[k]), rotation));
    }
  }
  for (std::size_t length = 1; length < seen.size(); ++length) {
    Candidate best;
    for (std::size_t i = 0; i + length < seen.size(); ++i) {
      const Departure change = difference(seen[i], seen[i + length]);
      const double size = size_of(change, rotation);
      const bool nearer_home = std::abs(positions[i] + positions[i + length]) < std::abs(best.from + best.to);
      if (size > best.size * (1 + 1e-9) || (size >= best.size * (1 - 1e-9) && nearer_home)) {
        best = {positions[i], positions[i + length], size, change};
      }
    }
    if (best.size >= kGoodEnough * largest) return best;
  }
  return {};
}

/// The axes worth moving: the one the error belongs to, those its function depends on, then all.
std::vector<int> axes_to_try(const Machine& machine, const ErrorTerm& term) {
  std::vector<int> axes;
  const auto add = [&](int axis) {
    if (axis >= 0 && std::find(axes.begin(), axes.end(), axis) == axes.end()) axes.push_back(axis);
  };
  if (term.body >= 0) add(machine.bodies[static_cast<std::size_t>(term.body)].axis);
  for (const int variable : term.function.variables()) {
    const Variable& v = machine.variables[static_cast<std::size_t>(variable)];
    if (v.kind == Variable::Kind::position) add(v.axis);
  }
  for (int i = 0; i < machine.axis_count(); ++i) add(i);
  return axes;
}

}  // namespace

std::vector<AxisMove> axis_moves(const Plan& plan) {
  const Machine& machine = plan.machine();
  std::vector<AxisMove> moves;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& axis = machine.axis(i);
    const double jog = axis.type == AxisType::rotary ? kRotaryJog : kLinearJog;
    Query query;
    query.q = home(machine);
    query.tool = tool_of(machine);
    AxisMove move;
    move.axis = i;
    const auto k = static_cast<std::size_t>(i);
    // Jog upwards, from below home where the travel ends there.
    move.from = query.q[k];
    if (axis.range && move.from + jog > (*axis.range)[1]) move.from = (*axis.range)[1] - jog;
    move.to = move.from + jog;
    query.q[k] = move.from;
    const Vec3 before = nominal_tip(plan, query);
    query.q[k] = move.to;
    move.tip = nominal_tip(plan, query) - before;
    move.body = axis.direction * jog;
    moves.push_back(move);
  }
  return moves;
}

std::vector<ErrorTest> error_tests(const Machine& machine, const Environment& environment, ErrorModel model) {
  std::vector<ErrorTest> tests;
  for (std::size_t i = 0; i < machine.errors.size(); ++i) {
    Machine alone = machine;
    alone.errors = {machine.errors[i]};
    const ErrorTerm& term = alone.errors.front();
    const bool rotation = term.name.is_rotation();
    ErrorTest test;
    test.error = i;
    test.at = home(machine);
    std::variant<Plan, MissingSensors> made = make_plan(alone, environment, model);
    const auto* plan = std::get_if<Plan>(&made);
    if (plan == nullptr) {
      tests.push_back(test);
      continue;
    }
    Query query;
    query.q = test.at;
    query.tool = tool_of(machine);
    const auto take = [&](const Departure& change) {
      test.tip = change.tip, test.rotation = change.rotation;
    };

    // An error that follows a sensor is seen best by letting the sensor change where the axes stand at mid
    // travel.
    for (const int variable : term.function.variables()) {
      const Variable& v = machine.variables[static_cast<std::size_t>(variable)];
      const auto given = environment.find(v.name);
      if (v.kind != Variable::Kind::sensor || test.sensor || given == environment.end()) continue;
      Environment warmer = environment;
      warmer[v.name] = given->second + 1;
      const auto changed = make_plan(alone, warmer, model);
      for (const int axis : axes_to_try(machine, term)) {
        const Body& body = machine.axis(axis);
        if (term.body >= 0 && machine.bodies[static_cast<std::size_t>(term.body)].axis == axis) {
          query.q[static_cast<std::size_t>(axis)] = travel_of(body)[1];
        }
      }
      const Departure change = difference(departure(*plan, query), departure(std::get<Plan>(changed), query));
      if (std::max(size_of(change, false), size_of(change, true)) > kNothing) {
        test.sensor = v.name;
        test.from = given->second;
        test.to = given->second + 1;
        test.at = query.q;
        take(change);
      }
      query.q = test.at;
    }
    if (test.sensor) {
      tests.push_back(test);
      continue;
    }

    Candidate best;
    int best_axis = -1;
    const std::vector<int> axes = axes_to_try(machine, term);
    // A constant rotation turns no dial by itself; it is then seen as a displacement.
    for (const bool as_rotation : {rotation, false}) {
      std::vector<Candidate> candidates;
      double largest = 0;
      for (const int axis : axes) {
        candidates.push_back(best_move(*plan, query, axis, as_rotation));
        largest = std::max(largest, candidates.back().size);
      }
      for (std::size_t k = 0; k < axes.size() && best_axis < 0 && largest > kNothing; ++k) {
        if (candidates[k].size >= kOwnAxisEnough * largest) best = candidates[k], best_axis = axes[k];
      }
      if (best_axis >= 0) break;
    }
    if (best_axis >= 0) {
      test.axis = best_axis;
      test.from = best.from;
      test.to = best.to;
      take(best.change);
    } else {
      take(departure(*plan, query));
    }
    tests.push_back(test);
  }
  return tests;
}

}  // namespace abbe::app
