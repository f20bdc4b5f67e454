#include "abbe/chain/method_fit.h"

#include <memory>
#include <utility>
#include <vector>

#include "abbe/chain/frozen_chain.h"
#include "abbe/chain/plan_impl.h"
#include "abbe/chain/printed_form.h"

namespace abbe {
namespace {

constexpr double kDegenerate = 1e-6;  // sine or volume below which a design is one for no direction

[[nodiscard]] std::string names(const Machine& machine, AxisSet axes) {
  std::string text;
  for (int i = 0; i < machine.axis_count(); ++i) {
    if ((axes >> i & 1U) != 0) text += (text.empty() ? "" : " ") + machine.axis(i).name;
  }
  return text.empty() ? "none" : text;
}

[[nodiscard]] int count(AxisSet axes) {
  int n = 0;
  for (; axes != 0; axes &= axes - 1) ++n;
  return n;
}

[[nodiscard]] std::optional<std::string> closed_form_obstacle(const Machine& machine, ErrorModel model,
                                                              const Tool& tool, AxisSet free) {
  if (model != ErrorModel::rigid) return "it is a product of rotations and needs the rigid model";
  // The shape of the chain is that of the machine without errors.
  Machine ideal = machine;
  ideal.errors.clear();
  const std::size_t variables = ideal.variables.size();
  const Plan whole = compile_plan(std::make_shared<const Machine>(std::move(ideal)),
                                  std::vector<double>(variables, 0.0), model);
  const Plan::Impl& plan = whole.impl();
  const AxisSet linear = free & ~plan.rotary, rotary = free & plan.rotary;
  if (count(linear) != 3) {
    return "it needs three linear axes that may move, this chain has " + names(machine, linear);
  }
  if (count(rotary) > 2) return "it needs at most two rotary axes that may move: " + names(machine, rotary);
  const auto all = (AxisSet{1} << plan.axis_count) - 1;
  if ((plan.rotary & all & ~free) != 0) return std::nullopt;

  // A pose off the symmetric ones, where good designs are degenerate too.
  std::array<double, kMaxAxes> q{};
  for (std::size_t k = 0; k < q.size(); ++k) q[k] = 0.4 + 0.3 * static_cast<double>(k % 3);
  Inputs<double> in;
  in.q = q.data();
  in.tip = tool.tip;
  FrozenChain chain;
  chain.freeze(plan, plan.nominal, in, free, nullptr);
  const FrozenChain::Shape shape = chain.shape(q, tool.axis);
  if (!(shape.volume > kDegenerate))
    return "the linear axes " + names(machine, linear) + " do not span space";
  if (!(shape.between_axes > kDegenerate))
    return "the rotary axes " + names(machine, rotary) + " are parallel: they cannot set a direction";
  if (!(shape.tool_to_axis > kDegenerate))
    return "the axis " + machine.axis(chain.rotary(0)).name + " turns the tool about itself";
  return std::nullopt;
}

}  // namespace

std::optional<std::string> method_obstacle(Method method, const Machine& machine, ErrorModel model,
                                           const Tool& tool, AxisSet free) {
  switch (method) {
    case Method::newton:
    case Method::one_step:
      break;
    case Method::closed_form:
      return closed_form_obstacle(machine, model, tool, free);
    case Method::printed:
      return printed_form_obstacle(machine, tool, free);
  }
  return std::nullopt;
}

}  // namespace abbe
