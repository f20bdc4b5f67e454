#pragma once

#include <memory>

#include "abbe/chain/plan.h"
#include "abbe/kernel/flat_view.h"

namespace abbe::kernel {

/// A plan laid out for kernels: immutable, shared by threads.
class FlatPlan {
 public:
  /// null if the machine has functions that are not tabulated (of several axes, of velocities), more than
  /// kMaxFlatAxes axes, or other things that only the general walk knows.
  [[nodiscard]] static std::shared_ptr<const FlatPlan> make(const Plan& plan);
  ~FlatPlan();
  [[nodiscard]] const FlatView& view() const { return view_; }

 private:
  struct Data;
  FlatPlan();
  std::unique_ptr<Data> data_;
  FlatView view_;
};

}  // namespace abbe::kernel
