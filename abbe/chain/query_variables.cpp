#include "abbe/chain/query_variables.h"

#include "abbe/chain/walk.h"

namespace abbe {

QueryVariables query_variables(const Plan::Impl& plan, const Query& query) {
  QueryVariables read{plan.variables, std::vector<signed char>(plan.variables.size(), 0)};
  for (std::size_t i = 0; i < read.values.size(); ++i) {
    const Variable& variable = plan.machine->variables[i];
    const auto axis = static_cast<std::size_t>(variable.axis);
    if (variable.kind == Variable::Kind::position) {
      read.values[i] = file_position(query.q[axis], plan.unit[axis]);
      read.approach[i] = query.approach[axis];
    } else if (variable.kind == Variable::Kind::velocity && axis < query.velocity.size()) {
      read.values[i] = query.velocity[axis];
    } else if (variable.kind == Variable::Kind::acceleration && axis < query.acceleration.size()) {
      read.values[i] = query.acceleration[axis];
    }
  }
  return read;
}

}  // namespace abbe
