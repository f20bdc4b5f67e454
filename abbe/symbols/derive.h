#pragma once

#include <array>
#include <string>
#include <vector>

#include "abbe/core/linear_algebra.h"
#include "abbe/machine/machine.h"
#include "abbe/symbols/expression.h"

namespace abbe {

/// What the indices of symbols stand for.
struct SymbolNames {
  std::vector<ErrorName> errors;  ///< from the workpiece to the tool along the chain
  std::vector<std::string> axes;  ///< moving axes in chain order
};

/// The first-order equations of a machine: docs/theory/symbols.md. Every expression is linear in the
/// errors; positions are in mm and rad, numbers in mm.
struct Derivation {
  SymbolNames names;
  Vec3T<Expression> deviation;  ///< of the tip, actual - nominal, workpiece axes, mm
  Vec3T<Expression> tool_axis;  ///< of the tool axis, a difference of vectors, workpiece axes
  Vec3T<Expression> twist_d;    ///< tool twist: displacement in ideal tool axes at the tip, mm
  Vec3T<Expression> twist_e;    ///< and rotation, rad
};

/// The sum of adjoints (docs/theory/chain.md, equation 8) with symbols for errors and positions. An
/// error that is given stays a symbol whatever its function is; one that the chain does not let act
/// is in `names` and in no expression.
///
/// laws     EqualsTheNumericFirstOrderModel, TwistTurnedIntoWorkpieceAxesIsTheDeviation
[[nodiscard]] Derivation derive(const Machine& machine);

/// The same machine with every error of its inventory (six components per moving axis, the location
/// errors that act) besides those given.
[[nodiscard]] Machine with_inventory(const Machine& machine);

}  // namespace abbe
