#include "abbe/identify/error_effects.h"

#include <algorithm>
#include <variant>

#include "abbe/chain/predict.h"

namespace abbe {
namespace {

/// The machine with one error of one unit (mm or rad) and no other.
Machine with_unit_error(const Machine& machine, const ErrorName& name) {
  Machine out = machine;
  ErrorTerm term;
  term.name = name;
  term.function = ErrorFunction::constant(1);
  const auto body =
      std::find_if(out.bodies.begin(), out.bodies.end(), [&](const Body& b) { return b.name == name.axis; });
  term.body = static_cast<int>(body - out.bodies.begin());
  out.errors = {term};
  return out;
}

Query at(const Machine& machine, int axis, double position) {
  Query query;
  query.tool = tool_of(machine);
  if (axis >= 0) query.q[static_cast<std::size_t>(axis)] = position;
  return query;
}

}  // namespace

ErrorEffects::ErrorEffects(const Machine& machine, const std::vector<ModelTerm>& terms) {
  const auto is_linear = [&](int axis) { return machine.axis(axis).type == AxisType::linear; };
  std::vector<ErrorName> names;
  for (const ModelTerm& term : terms) {
    const auto known = std::find(names.begin(), names.end(), term.name);
    which_.push_back(static_cast<std::size_t>(known - names.begin()));
    if (known == names.end()) names.push_back(term.name);
  }
  for (const ErrorName& name : names) {
    const Machine unit = with_unit_error(machine, name);
    // A constant error asks for no sensor, so there is a plan.
    const auto plan = std::get<Plan>(make_plan(unit, {}, ErrorModel::first_order));
    const auto deviation = [&](int axis) { return predict(plan, at(unit, axis, 1)).deviation.position; };
    Affine& effect = effects_.emplace_back();
    effect.constant = predict(plan, at(unit, -1, 0)).deviation.position;
    for (int axis = 0; axis < machine.axis_count(); ++axis)
      effect.gradient.push_back(is_linear(axis) ? Vec3(deviation(axis) - effect.constant) : Vec3::Zero());
  }
  Machine ideal = machine;
  ideal.errors.clear();
  const auto plan = std::get<Plan>(make_plan(ideal, {}, ErrorModel::first_order));
  const Vec3 home = nominal_tip(plan, at(ideal, -1, 0));
  for (int axis = 0; axis < machine.axis_count(); ++axis)
    motion_.push_back(is_linear(axis) ? Vec3(nominal_tip(plan, at(ideal, axis, 1)) - home) : Vec3::Zero());
}

Vec3 ErrorEffects::of(std::size_t i, const AxisState& state) const {
  const Affine& effect = effects_[which_[i]];
  Vec3 out = effect.constant;
  for (std::size_t axis = 0; axis < effect.gradient.size(); ++axis)
    out += effect.gradient[axis] * state.q[axis];
  return out;
}

}  // namespace abbe
