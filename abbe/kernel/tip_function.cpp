#include "abbe/kernel/tip_function.h"

namespace abbe::kernel {

Vec3 TipFunction::operator()(const Query& query, bool* outside) const {
  if (flat_ == nullptr) return actual_tip(plan_, query, outside);
  Vec3 tip;
  unsigned char lane = Lane::ordinary;
  kernel_->one_tip(flat_->view(), query.tool.tip.data(), query.approach.data(), query.q.data(), tip.data(), &lane);
  if (lane != Lane::ordinary && outside != nullptr) *outside = true;
  const double sum = tip.sum();
  return sum - sum == 0 ? tip : Vec3(Vec3::Zero());
}

}  // namespace abbe::kernel
