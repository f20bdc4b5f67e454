#pragma once

#include <array>
#include <span>
#include <vector>

#include "abbe/chain/plan_impl.h"

namespace abbe {

/// A polynomial, table or sine of one axis position inside an error, in the units of the file:
/// component += factor * node(position).
struct AxisLeaf {
  const ErrorFunction* function = nullptr;
  const ErrorFunction::Node* node = nullptr;
  double factor = 1;  ///< with the conversion of the error to mm or rad
  int component = 0;
};

/// How far a tabulated sine may be from the sine.
inline constexpr double kTabulatedMm = 1e-12, kTabulatedRad = 1e-15;

/// Appends to the plan the tables that stand for `leaves`, all of one axis: one for what does not repeat, one
/// per period. The plan's travels and units are set. `constant` is added to the first one.
/// laws     TabulatedErrorsAreTheErrors
void append_tables(Plan::Impl& plan, int axis, std::span<const AxisLeaf> leaves,
                   const std::array<double, kComponents>& constant);

}  // namespace abbe
