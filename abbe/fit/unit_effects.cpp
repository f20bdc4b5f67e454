#include "abbe/fit/unit_effects.h"

#include <algorithm>
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
  const bool turns = std::any_of(machine.bodies.begin(), machine.bodies.end(),
                                 [](const Body& body) { return body.type == AxisType::rotary; });
  for (std::size_t k = 0; !turns && k < out.plans_.size(); ++k)
    out.affine_.push_back(affine_of(out.plans_[k], machine.axis_count()));
  return out;
}

Twist UnitEffects::predicted(const Plan& plan, const Query& query) {
  const Prediction prediction = predict(plan, query);
  return {prediction.deviation.position, nominal_pose(plan, query).R * prediction.tool_twist.e};
}

UnitEffects::Affine UnitEffects::affine_of(const Plan& plan, Eigen::Index axes) {
  Query query;
  query.tool.tip.setZero();
  Affine out{predicted(plan, query), Eigen::Matrix3Xd(3, axes + 3)};
  for (Eigen::Index i = 0; i < axes + 3; ++i) {
    double& moved = i < axes ? query.q[static_cast<std::size_t>(i)] : query.tool.tip[i - axes];
    moved = 1;
    out.gradient.col(i) = predicted(plan, query).d - out.constant.d;
    moved = 0;
  }
  return out;
}

Twist UnitEffects::at(std::size_t error, const Query& query) const {
  if (affine_.empty()) return predicted(plans_[error], query);
  const Affine& effect = affine_[error];
  const Eigen::Index axes = effect.gradient.cols() - 3;
  Twist out = effect.constant;
  for (Eigen::Index i = 0; i < axes; ++i)
    out.d += effect.gradient.col(i) * query.q[static_cast<std::size_t>(i)];
  out.d += effect.gradient.rightCols<3>() * query.tool.tip;
  return out.d.allFinite() ? out : Twist{};
}

}  // namespace abbe
