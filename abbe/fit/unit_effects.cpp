#include "abbe/fit/unit_effects.h"

#include <utility>
#include <variant>

namespace abbe {

std::optional<int> body_of(const Machine& machine, const ErrorName& name) {
  if (name.axis == "t") return kToolBody;
  if (name.axis == "w") return kWorkpieceBody;
  for (std::size_t i = 0; i < machine.bodies.size(); ++i)
    if (machine.bodies[i].name == name.axis) return static_cast<int>(i);
  return std::nullopt;
}

std::optional<UnitEffects> UnitEffects::make(const Machine& machine, const std::vector<std::string>& names) {
  UnitEffects out;
  for (const std::string& text : names) {
    const std::optional<ErrorName> name = read_error_name(text);
    const std::optional<int> body = name ? body_of(machine, *name) : std::nullopt;
    if (!body) return std::nullopt;
    Machine single = machine;
    single.errors = {ErrorTerm{*name, *body, ErrorFunction::constant(1), 1, std::nullopt}};
    auto plan = make_plan(single, {}, ErrorModel::first_order);
    if (!std::holds_alternative<Plan>(plan)) return std::nullopt;
    out.plans_.push_back(std::move(std::get<Plan>(plan)));
  }
  return out;
}

Twist UnitEffects::at(std::size_t error, const Query& query) const {
  const Plan& plan = plans_[error];
  const Prediction prediction = predict(plan, query);
  return {prediction.deviation.position, nominal_pose(plan, query).R * prediction.tool_twist.e};
}

}  // namespace abbe
