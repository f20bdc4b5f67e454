#include "abbe/chain/correction_step.h"

#include <algorithm>

namespace abbe {
namespace {

constexpr double kParallel = 1e-12;     // |sin| between direction columns below which they are one
constexpr double kNoEffect = 1e-8;      // rad per rad: the axis turns the tool about itself
constexpr double kJointLength = 300.0;  // mm: weighs direction against position where both cannot be had

[[nodiscard]] double weight_of(const std::array<double, kMaxAxes>& weights, int axis) {
  const double w = weights[static_cast<std::size_t>(axis)];
  return w > 0 && std::isfinite(w) ? w : 1.0;
}

/// W^-1 (J W^-1)^+ for a J whose columns belong to `axes`: minimises sum (w_i dq_i)^2.
[[nodiscard]] SmallMatrix weighted_inverse(SmallMatrix j, const std::array<int, kMaxAxes>& axes,
                                           const std::array<double, kMaxAxes>& weights, int& rank,
                                           double least = 1e-7) {
  const auto scale = [&](SmallMatrix& m) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(m.count); ++i) {
      for (double& x : m.columns[i]) x /= weight_of(weights, axes[i]);
    }
  };
  scale(j);
  SmallMatrix inverse = pseudo_inverse(j, rank, least);
  scale(inverse);
  return inverse;
}

[[nodiscard]] double dot3(const SmallMatrix::Column& c, const Vec3& x) {
  return c[0] * x.x() + c[1] * x.y() + c[2] * x.z();
}

}  // namespace

void CorrectionStep::prepare(const Plan::Impl& plan, const CarriedColumns& columns, const Vec3& axis,
                             AxisSet free, const std::array<double, kMaxAxes>& weights) {
  // Two unit vectors across the axis without a root (Duff et al., Building an Orthonormal Basis,
  // Revisited, 2017).
  const double sign = std::copysign(1.0, axis.z()), a = -1.0 / (sign + axis.z()), b = axis.x() * axis.y() * a;
  first_ = {1.0 + sign * axis.x() * axis.x() * a, sign * b, -sign * axis.x()};
  second_ = {b, sign + axis.y() * axis.y() * a, -axis.y()};

  linear_count_ = rotary_count_ = 0;
  for (int i = 0; i < plan.axis_count; ++i) {
    if ((free & (AxisSet{1} << i)) == 0) continue;
    const auto k = static_cast<std::size_t>(i);
    position_[k] = columns.position.col(i);
    if ((plan.rotary & (AxisSet{1} << i)) != 0) {
      direction_[k] = across(columns.tool_axis.col(i));
      rotary_[static_cast<std::size_t>(rotary_count_++)] = i;
    } else {
      linear_[static_cast<std::size_t>(linear_count_++)] = i;
    }
  }
  joint_ = (rotary_count_ > 2 && linear_count_ >= 3) || (linear_count_ > 3 && rotary_count_ >= 2);
  singular_axis_ = kNone;
  if (joint_) {
    prepare_joint(weights);
    return;
  }
  prepare_rotary(weights);
  prepare_linear(weights);
}

void CorrectionStep::prepare_rotary(const std::array<double, kMaxAxes>& weights) {
  rotary_rows_ = {Vec2::Zero(), Vec2::Zero()};
  if (rotary_count_ == 0) return;
  const Vec2 c0 = direction_[static_cast<std::size_t>(rotary_[0])];
  if (rotary_count_ == 1) {
    // Least squares: dq = -(c.r) / (c.c)
    if (c0.squaredNorm() > kNoEffect * kNoEffect) rotary_rows_[0] = c0 / c0.squaredNorm();
    return;
  }
  if (rotary_count_ == 2) {
    const Vec2 c1 = direction_[static_cast<std::size_t>(rotary_[1])];
    const double det = c0.x() * c1.y() - c0.y() * c1.x();
    if (std::abs(det) <= kParallel) {
      singular_axis_ = c0.squaredNorm() < c1.squaredNorm() ? rotary_[0] : rotary_[1];
      return;
    }
    rotary_rows_ = {Vec2(c1.y() / det, -c1.x() / det), Vec2(-c0.y() / det, c0.x() / det)};
    return;
  }
  SmallMatrix j;
  j.rows = 2;
  j.count = rotary_count_;
  for (std::size_t i = 0; i < static_cast<std::size_t>(rotary_count_); ++i) {
    const Vec2& c = direction_[static_cast<std::size_t>(rotary_[i])];
    j.columns[i] = {c.x(), c.y()};
  }
  int rank = 0;
  rotary_inverse_ = weighted_inverse(j, rotary_, weights, rank);
}

void CorrectionStep::prepare_linear(const std::array<double, kMaxAxes>& weights) {
  square_ = false;
  position_rank_ = 0;
  if (linear_count_ == 0) return;
  if (linear_count_ == 3) {
    const Vec3& a = position_[static_cast<std::size_t>(linear_[0])];
    const Vec3& b = position_[static_cast<std::size_t>(linear_[1])];
    const Vec3& c = position_[static_cast<std::size_t>(linear_[2])];
    // Inverse by cross products: rows b x c, c x a, a x b over the volume.
    const Vec3 bc = b.cross(c);
    const double volume = a.dot(bc);
    if (std::abs(volume) > kDependentAxes) {
      const double inverse = 1.0 / volume;
      linear_rows_ = {Vec3(bc * inverse), Vec3(c.cross(a) * inverse), Vec3(a.cross(b) * inverse)};
      square_ = true;
      position_rank_ = 3;
      return;
    }
  }
  // Fewer, dependent or redundant axes: least squares, and of the solutions the smallest weighted step.
  SmallMatrix j;
  j.rows = 3;
  j.count = linear_count_;
  for (std::size_t i = 0; i < static_cast<std::size_t>(linear_count_); ++i) {
    const Vec3& a = position_[static_cast<std::size_t>(linear_[i])];
    j.columns[i] = {a.x(), a.y(), a.z()};
  }
  linear_inverse_ =
      weighted_inverse(j, linear_, weights, position_rank_, linear_count_ == 3 ? kDependentAxes : 1e-7);
}

/// All axes together: dq = W^-1 (J W^-1)^+ r, rows of J three positions and two directions.
void CorrectionStep::prepare_joint(const std::array<double, kMaxAxes>& weights) {
  SmallMatrix j;
  j.rows = 5;
  std::array<int, kMaxAxes> axes{};
  for (int i = 0; i < linear_count_ + rotary_count_; ++i) {
    const bool is_linear = i < linear_count_;
    const int axis = is_linear ? linear_[static_cast<std::size_t>(i)]
                               : rotary_[static_cast<std::size_t>(i - linear_count_)];
    const Vec3& p = position_[static_cast<std::size_t>(axis)];
    const Vec2 a = is_linear ? Vec2(0, 0) : Vec2(direction_[static_cast<std::size_t>(axis)] * kJointLength);
    axes[static_cast<std::size_t>(i)] = axis;
    j.columns[static_cast<std::size_t>(i)] = {p.x(), p.y(), p.z(), a.x(), a.y()};
  }
  j.count = linear_count_ + rotary_count_;
  int rank = 0;
  joint_inverse_ = weighted_inverse(j, axes, weights, rank);
  position_rank_ = std::min(3, rank);
}

std::array<double, kMaxAxes> CorrectionStep::solve(const Residual& r, Residual& left) const {
  std::array<double, kMaxAxes> dq{};
  left = r;
  const auto move = [&](int axis, double by) {
    const auto k = static_cast<std::size_t>(axis);
    dq[k] = by;
    left.position += position_[k] * by;
  };
  const auto turn = [&](int axis, double by) {
    move(axis, by);
    left.direction += direction_[static_cast<std::size_t>(axis)] * by;
  };
  if (joint_) {
    const Vec2 direction = r.direction * kJointLength;
    for (int i = 0; i < joint_inverse_.count; ++i) {
      const SmallMatrix::Column& row = joint_inverse_.columns[static_cast<std::size_t>(i)];
      const double by = -(dot3(row, r.position) + row[3] * direction.x() + row[4] * direction.y());
      if (i < linear_count_)
        move(linear_[static_cast<std::size_t>(i)], by);
      else
        turn(rotary_[static_cast<std::size_t>(i - linear_count_)], by);
    }
    return dq;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(rotary_count_); ++i) {
    const SmallMatrix::Column& row = rotary_inverse_.columns[i];
    const double by = rotary_count_ <= 2 ? rotary_rows_[i].dot(r.direction)
                                         : row[0] * r.direction.x() + row[1] * r.direction.y();
    turn(rotary_[i], -by);
  }
  const Vec3 remaining = left.position;
  for (std::size_t i = 0; i < static_cast<std::size_t>(linear_count_); ++i) {
    move(linear_[i],
         square_ ? -linear_rows_[i].dot(remaining) : -dot3(linear_inverse_.columns[i], remaining));
  }
  return dq;
}

}  // namespace abbe
