#pragma once

#include <array>
#include <memory>
#include <span>

#include "abbe/chain/predict.h"
#include "abbe/kernel/flat_plan.h"
#include "abbe/kernel/kernel.h"

namespace abbe::kernel {

/// A tip, and whether an error was held beyond its ends there.
struct TipAt {
  Vec3 tip = Vec3::Zero();
  bool outside = false;
};

/// abbe::actual_tip for many calls: by a kernel where the machine allows it, else by the general walk.
/// An immutable value, shared by threads.
///
/// laws     TipsOfAllKernelsAreTheGeneralTips, TipFunctionIsTheGeneralTip,
/// NeighboursTogetherAreTheGeneralTips cost     no allocation
class TipFunction {
 public:
  explicit TipFunction(const Plan& plan) : plan_(plan), flat_(FlatPlan::make(plan)), kernel_(&best()) {}

  /// `outside` (may be null) is set when an error was held beyond its ends; never cleared.
  [[nodiscard]] Vec3 operator()(const Query& query, bool* outside) const;

  /// Most poses of one call of neighbours().
  static constexpr std::size_t kMost = 16;
  /// The tips where the three axes `axes` stand at at[i], mm, and all else is as in `query`; to 1e-11 mm what
  /// single calls give. False: not for this machine. cost    a third of single calls where the poses are near
  /// each other
  [[nodiscard]] bool neighbours(const Query& query, const std::array<std::size_t, 3>& axes,
                                std::span<const Vec3> at, std::span<TipAt> tips) const;

 private:
  Plan plan_;
  std::shared_ptr<const FlatPlan> flat_;
  const Kernel* kernel_;
};

}  // namespace abbe::kernel
