#pragma once

#include <vector>

#include "abbe/chain/plan_impl.h"

namespace abbe {

/// What error functions read, for one query: the file's variables in its own units and the directions of
/// approach, indexed as Machine::variables.
struct QueryVariables {
  std::vector<double> values;
  std::vector<signed char> approach;
};

[[nodiscard]] QueryVariables query_variables(const Plan::Impl& plan, const Query& query);

}  // namespace abbe
