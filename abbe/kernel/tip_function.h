#pragma once

#include <memory>

#include "abbe/chain/predict.h"
#include "abbe/kernel/flat_plan.h"
#include "abbe/kernel/kernel.h"

namespace abbe::kernel {

/// abbe::actual_tip for many calls: by a kernel where the machine allows it, else by the general walk.
/// An immutable value, shared by threads.
///
/// laws     TipsOfAllKernelsAreTheGeneralTips, TipFunctionIsTheGeneralTip
/// cost     no allocation
class TipFunction {
 public:
  explicit TipFunction(const Plan& plan) : plan_(plan), flat_(FlatPlan::make(plan)), kernel_(&best()) {}

  /// `outside` (may be null) is set when an error was held beyond its ends; never cleared.
  [[nodiscard]] Vec3 operator()(const Query& query, bool* outside) const;

 private:
  Plan plan_;
  std::shared_ptr<const FlatPlan> flat_;
  const Kernel* kernel_;
};

}  // namespace abbe::kernel
