#include "abbe/kernel/tip_function.h"

#include <cassert>

namespace abbe::kernel {

Vec3 TipFunction::operator()(const Query& query, bool* outside) const {
  if (flat_ == nullptr) return actual_tip(plan_, query, outside);
  Vec3 tip;
  unsigned char lane = Lane::ordinary;
  kernel_->one_tip(flat_->view(), query.tool.tip.data(), query.approach.data(), query.q.data(), tip.data(),
                   &lane);
  if (lane != Lane::ordinary && outside != nullptr) *outside = true;
  const double sum = tip.sum();
  return sum - sum == 0 ? tip : Vec3(Vec3::Zero());
}

bool TipFunction::neighbours(const Query& query, const std::array<std::size_t, 3>& axes,
                             std::span<const Vec3> at, std::span<TipAt> tips) const {
  assert(at.size() <= kMost && tips.size() >= at.size());
  if (flat_ == nullptr) return false;
  const FlatView& view = flat_->view();
  // Structure of arrays: resting axes stand at one place in all poses.
  std::array<std::array<double, kMost>, kMaxFlatAxes> places;
  std::array<const double*, kMaxFlatAxes> q;
  const auto axis_count = static_cast<std::size_t>(view.axis_count);
  for (std::size_t i = 0; i < axis_count; ++i) {
    q[i] = places[i].data();
    if (i != axes[0] && i != axes[1] && i != axes[2]) places[i].fill(query.q[i]);
  }
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < at.size(); ++i) places[axes[k]][i] = at[i][static_cast<Eigen::Index>(k)];
  std::array<std::array<double, kMost>, 3> found;
  const std::array<double*, 3> to = {found[0].data(), found[1].data(), found[2].data()};
  std::array<unsigned char, kMost> lanes{};
  kernel_->tips(view, query.tool.tip.data(), query.approach.data(), q.data(), at.size(), to.data(),
                lanes.data());
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Vec3 tip(found[0][i], found[1][i], found[2][i]);
    const double sum = tip.sum();
    tips[i] = {sum - sum == 0 ? tip : Vec3(Vec3::Zero()), lanes[i] != Lane::ordinary};
  }
  return true;
}

}  // namespace abbe::kernel
