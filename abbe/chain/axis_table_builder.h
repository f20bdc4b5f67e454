#pragma once

#include <array>
#include <compare>
#include <span>
#include <vector>

#include "abbe/chain/plan_impl.h"

namespace abbe {

/// The direction of approach for which a part of an error counts; 0: every one.
struct ApproachKey {
  int direction = 0, axis = 0;
  friend auto operator<=>(const ApproachKey&, const ApproachKey&) = default;
};

/// A polynomial, table or sine of one axis position inside an error, in the units of the file:
/// component += factor * node(position).
struct AxisLeaf {
  const ErrorFunction* function = nullptr;
  const ErrorFunction::Node* node = nullptr;  ///< null: the constant `factor`
  double factor = 1;                          ///< with the conversion of the error to mm or rad
  int component = 0;
  ApproachKey approach;
};

/// How far a tabulated sine may be from the sine.
inline constexpr double kTabulatedMm = 1e-12, kTabulatedRad = 1e-15;

/// Appends to the plan the tables that stand for `leaves`, all of one axis and one direction of approach: one
/// for what does not repeat, one per period. The plan's travels and units are set. `constant` is added to the
/// first one. No leaves: one table of `constant`. laws     TabulatedErrorsAreTheErrors
void append_tables(Plan::Impl& plan, int axis, std::span<const AxisLeaf> leaves,
                   const std::array<double, kComponents>& constant);

}  // namespace abbe
