#pragma once

#include <memory>
#include <vector>

#include "abbe/symbols/expression.h"

namespace abbe {

struct GroupedSum;

/// A factor as it is written: a symbol, or a sum in brackets.
struct GroupedFactor {
  Symbol symbol;
  std::shared_ptr<const GroupedSum> bracket;  ///< null: the symbol
};

/// +-number * factors.
struct GroupedTerm {
  bool negative = false;
  double number = 1;  ///< > 0
  std::vector<GroupedFactor> factors;
};

struct GroupedSum {
  std::vector<GroupedTerm> terms;
};

/// Brings an expression into the form in which such equations are written: by products of sines and
/// cosines; within them errors that stand alone come first, then errors by their lever, those with the
/// same lever in one bracket:
///
///     -EXX + EXY + Y*ECX - Z*(EBX - EBY) - 120*EBZ - cos(C)*(EXC + Z*EBC)
///
/// law      GroupingKeepsTheValue
[[nodiscard]] GroupedSum group_terms(const Expression& expression);

}  // namespace abbe
