#pragma once

#include <memory>
#include <vector>

#include "abbe/kernel/flat_windows.h"

namespace abbe::kernel {

/// The steps of the first-order walk in single precision, and what they point to.
struct SingleSteps {
  std::vector<FlatOpOf<float>> steps;
  std::vector<std::unique_ptr<FlatTable>> tables;  ///< of single steps
  std::vector<std::vector<WindowRow>> windows;     ///< of all tables
  std::vector<std::vector<double>> rows;           ///< of tables with a constant twist in them
};

/// Rounds the steps. A constant twist beside a twist that is one table and nothing else becomes part of its
/// coefficients: across a translation t behind the first of the two
///
///   twist, then constant: d = d0 + e0 x t      constant, then twist: d = d0 - e0 x t,  e = e0
///
/// and the steps stay those of the same first-order sum.
///
/// laws   Kernels.BatchesInSinglePrecisionAreTheFirstOrderStep
/// cost   once per plan
/// source docs/theory/kernels.md
[[nodiscard]] SingleSteps single_steps(const std::vector<FlatOp>& steps);

/// Makes and keeps the windows of a table.
void give_windows(FlatTable& table, std::vector<std::vector<WindowRow>>& windows);

}  // namespace abbe::kernel
