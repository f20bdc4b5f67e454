#include "abbe/fit/unit_effects.h"

#include <utility>
#include <variant>

#include "abbe/machine/error_body.h"

namespace abbe {

std::optional<UnitEffects> UnitEffects::make(const Machine& machine, const std::vector<std::string>& names) {
  UnitEffects out;
  for (const std::string& text : names) {
    const std::optional<ErrorName> name = read_error_name(text);
    const std::optional<Machine> single = name ? with_unit_error(machine, *name) : std::nullopt;
    if (!single) return std::nullopt;
    auto plan = make_plan(*single, {}, ErrorModel::first_order);
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
