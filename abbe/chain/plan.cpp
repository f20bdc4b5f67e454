#include "abbe/chain/plan.h"

#include <algorithm>
#include <cmath>

#include "abbe/chain/plan_impl.h"

namespace abbe {

const Machine& Plan::machine() const { return *impl_->machine; }
ErrorModel Plan::model() const { return impl_->model; }

Tool tool_of(const Machine& machine) { return tool_of(machine, machine.tool.length); }

Tool tool_of(const Machine& machine, double gauge_length) {
  // tip = origin - length * axis
  return {machine.tool.origin - gauge_length * machine.tool.axis, machine.tool.axis};
}

std::variant<Plan, MissingSensors> make_plan(const Machine& machine, const Environment& environment,
                                             ErrorModel model) {
  std::vector<bool> used(machine.variables.size(), false);
  for (const ErrorTerm& error : machine.errors) {
    for (const int v : error.function.variables()) used[static_cast<std::size_t>(v)] = true;
  }
  MissingSensors missing;
  std::vector<double> values(machine.variables.size(), 0.0);
  for (std::size_t i = 0; i < machine.variables.size(); ++i) {
    const Variable& variable = machine.variables[i];
    if (!used[i] || variable.kind == Variable::Kind::position) continue;
    const auto given = environment.find(variable.name);
    if (given != environment.end() && std::isfinite(given->second)) {
      values[i] = given->second;
    } else if (given != environment.end() || variable.kind == Variable::Kind::sensor) {
      // Not given, or not a number: either way the error has no value. Velocities default to zero.
      missing.names.push_back(variable.name);
    }
  }
  if (!missing.names.empty()) return missing;
  return compile_plan(std::make_shared<const Machine>(machine), std::move(values), model);
}

}  // namespace abbe
