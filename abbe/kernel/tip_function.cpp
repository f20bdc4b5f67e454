#include "abbe/kernel/tip_function.h"

namespace abbe::kernel {
namespace {

[[nodiscard]] Vec3 finite_or_zero(const Vec3& tip) {
  const double sum = tip.sum();
  return sum - sum == 0 ? tip : Vec3(Vec3::Zero());
}

}  // namespace

Vec3 TipFunction::operator()(const Query& query, bool* outside) const {
  if (flat_ == nullptr) return actual_tip(plan_, query, outside);
  Vec3 tip;
  unsigned char lane = Lane::ordinary;
  kernel_->one_tip(flat_->view(), query.tool.tip.data(), query.approach.data(), query.q.data(), tip.data(), &lane);
  if (lane != Lane::ordinary && outside != nullptr) *outside = true;
  return finite_or_zero(tip);
}

TipFunction::Two TipFunction::two(Query& query, const std::array<std::size_t, 3>& axes, const Vec3& a,
                                  const Vec3& b, bool* outside) const {
  const auto move_to = [&](const Vec3& m) {
    for (std::size_t k = 0; k < 3; ++k) query.q[axes[k]] = m[static_cast<Eigen::Index>(k)];
  };
  if (flat_ == nullptr) {
    Two tips;
    move_to(a);
    tips.a = actual_tip(plan_, query, outside);
    move_to(b);
    tips.b = actual_tip(plan_, query, outside);
    return tips;
  }
  const FlatView& view = flat_->view();
  double pairs[kMaxFlatAxes][2];
  std::array<const double*, kMaxFlatAxes> q;
  for (std::size_t i = 0; i < static_cast<std::size_t>(view.axis_count); ++i) {
    pairs[i][0] = pairs[i][1] = query.q[i];
    q[i] = pairs[i];
  }
  for (std::size_t k = 0; k < 3; ++k) {
    pairs[axes[k]][0] = a[static_cast<Eigen::Index>(k)];
    pairs[axes[k]][1] = b[static_cast<Eigen::Index>(k)];
  }
  double tip[3][2];
  const std::array<double*, 3> to = {tip[0], tip[1], tip[2]};
  unsigned char lanes[2] = {Lane::ordinary, Lane::ordinary};
  kernel_->tips(view, query.tool.tip.data(), query.approach.data(), q.data(), 2, to.data(), lanes);
  if ((lanes[0] | lanes[1]) != Lane::ordinary && outside != nullptr) *outside = true;
  return {finite_or_zero({tip[0][0], tip[1][0], tip[2][0]}), finite_or_zero({tip[0][1], tip[1][1], tip[2][1]})};
}

}  // namespace abbe::kernel
