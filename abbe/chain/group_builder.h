#pragma once

#include <map>
#include <utility>

#include "abbe/chain/plan_impl.h"

namespace abbe {

/// A body (index, kToolBody or kWorkpieceBody) and a class of errors: one error factor of the chain.
using GroupKey = std::pair<int, ErrorClass>;
using GroupIndex = std::map<GroupKey, int>;  ///< -> index in Plan::Impl::groups

/// Fills groups, tables and terms of `plan` from its machine's errors: functions of frozen variables
/// become constants, polynomials and tables of positions tables, all others stay functions.
/// `only` >= 0 keeps that one error.
[[nodiscard]] GroupIndex build_groups(Plan::Impl& plan, int only);

}  // namespace abbe
