#include "abbe/chain/correction_step.h"

#include <algorithm>

namespace abbe {
namespace {

constexpr double kParallel = 1e-12;     // |sin| between direction columns below which they are one
constexpr double kNoEffect = 1e-8;      // rad per rad: the axis turns the tool about itself
constexpr double kDependent = 1e-9;     // volume of three unit directions below which they are dependent
constexpr double kJointLength = 300.0;  // mm: weighs direction against position where both cannot be had

[[nodiscard]] double weight_of(const std::array<double, kMaxAxes>& weights, int axis) {
  const double w = weights[static_cast<std::size_t>(axis)];
  return w > 0 && std::isfinite(w) ? w : 1.0;
}

}  // namespace

void CorrectionStep::prepare(const Machine& machine, const CarriedColumns& columns, const Vec3& axis,
                             AxisSet free, const std::array<double, kMaxAxes>& weights) {
  // Any two unit vectors across the axis: start from the coordinate farthest from it.
  Eigen::Index smallest = 0;
  axis.cwiseAbs().minCoeff(&smallest);
  const Vec3 first = axis.cross(Vec3(Vec3::Unit(smallest))).normalized();
  basis_.col(0) = first;
  basis_.col(1) = axis.cross(first);

  linear_count_ = rotary_count_ = 0;
  const int count = std::min(machine.axis_count(), kMaxAxes);
  for (int i = 0; i < count; ++i) {
    if ((free & (AxisSet{1} << i)) == 0) continue;
    const auto k = static_cast<std::size_t>(i);
    position_[k] = columns.position.col(i);
    if (machine.axis(i).type == AxisType::rotary) {
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
  rotary_inverse_.setZero();
  if (rotary_count_ == 0) return;
  const Eigen::Vector2d c0 = direction_[static_cast<std::size_t>(rotary_[0])];
  if (rotary_count_ == 1) {
    // Least squares: dq = -(c.r) / (c.c)
    if (c0.squaredNorm() > kNoEffect * kNoEffect) rotary_inverse_.row(0) = c0.transpose() / c0.squaredNorm();
    return;
  }
  if (rotary_count_ > 2) {
    Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxAxes> c(2, rotary_count_);
    for (int i = 0; i < rotary_count_; ++i) {
      const int axis = rotary_[static_cast<std::size_t>(i)];
      c.col(i) = direction_[static_cast<std::size_t>(axis)] / weight_of(weights, axis);
    }
    Eigen::CompleteOrthogonalDecomposition<decltype(c)> decomposition;
    decomposition.setThreshold(kDependent);
    decomposition.compute(c);
    rotary_pseudo_ = decomposition.pseudoInverse();
    for (int i = 0; i < rotary_count_; ++i) {
      rotary_pseudo_.row(i) /= weight_of(weights, rotary_[static_cast<std::size_t>(i)]);
    }
    return;
  }
  const Eigen::Vector2d c1 = direction_[static_cast<std::size_t>(rotary_[1])];
  const double det = c0.x() * c1.y() - c0.y() * c1.x();
  if (std::abs(det) <= kParallel) {
    singular_axis_ = c0.squaredNorm() < c1.squaredNorm() ? rotary_[0] : rotary_[1];
    return;
  }
  rotary_inverse_ << c1.y() / det, -c1.x() / det, -c0.y() / det, c0.x() / det;
}

void CorrectionStep::prepare_linear(const std::array<double, kMaxAxes>& weights) {
  square_ = false;
  position_rank_ = 0;
  if (linear_count_ == 0) return;
  if (linear_count_ == 3) {
    const Vec3 &a = position_[static_cast<std::size_t>(linear_[0])],
               &b = position_[static_cast<std::size_t>(linear_[1])],
               &c = position_[static_cast<std::size_t>(linear_[2])];
    // Inverse by cross products: rows b x c, c x a, a x b over the volume.
    const Vec3 bc = b.cross(c);
    const double volume = a.dot(bc);
    if (std::abs(volume) > kDependent) {
      linear_inverse_.row(0) = bc.transpose() / volume;
      linear_inverse_.row(1) = c.cross(a).transpose() / volume;
      linear_inverse_.row(2) = a.cross(b).transpose() / volume;
      square_ = true;
      position_rank_ = 3;
      return;
    }
  }
  // Fewer, dependent or redundant axes: least squares, and of the solutions the smallest weighted step.
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxAxes> a(3, linear_count_);
  for (int i = 0; i < linear_count_; ++i) {
    const int axis = linear_[static_cast<std::size_t>(i)];
    a.col(i) = position_[static_cast<std::size_t>(axis)] / weight_of(weights, axis);
  }
  Eigen::CompleteOrthogonalDecomposition<decltype(a)> decomposition;
  decomposition.setThreshold(kDependent);
  decomposition.compute(a);
  position_rank_ = static_cast<int>(decomposition.rank());
  linear_pseudo_ = decomposition.pseudoInverse();
  for (int i = 0; i < linear_count_; ++i) {
    linear_pseudo_.row(i) /= weight_of(weights, linear_[static_cast<std::size_t>(i)]);
  }
}

/// All axes together: dq = W^-1 (J W^-1)^+ r, rows of J three positions and two directions.
void CorrectionStep::prepare_joint(const std::array<double, kMaxAxes>& weights) {
  const int count = linear_count_ + rotary_count_;
  Eigen::Matrix<double, 5, Eigen::Dynamic, 0, 5, kMaxAxes> j(5, count);
  for (int i = 0; i < count; ++i) {
    const bool is_linear = i < linear_count_;
    const int axis = is_linear ? linear_[static_cast<std::size_t>(i)]
                               : rotary_[static_cast<std::size_t>(i - linear_count_)];
    j.col(i).head<3>() = position_[static_cast<std::size_t>(axis)];
    j.col(i).tail<2>() = is_linear
                             ? Eigen::Vector2d(Eigen::Vector2d::Zero())
                             : Eigen::Vector2d(direction_[static_cast<std::size_t>(axis)] * kJointLength);
    j.col(i) /= weight_of(weights, axis);
  }
  Eigen::CompleteOrthogonalDecomposition<decltype(j)> decomposition;
  decomposition.setThreshold(kDependent);
  decomposition.compute(j);
  position_rank_ = std::min(3, static_cast<int>(decomposition.rank()));
  joint_inverse_ = decomposition.pseudoInverse();
  for (int i = 0; i < count; ++i) {
    const int axis = i < linear_count_ ? linear_[static_cast<std::size_t>(i)]
                                       : rotary_[static_cast<std::size_t>(i - linear_count_)];
    joint_inverse_.row(i) /= weight_of(weights, axis);
  }
  joint_inverse_.rightCols<2>() *= kJointLength;
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
    Eigen::Matrix<double, 5, 1> rows;
    rows << r.position, r.direction;
    for (int i = 0; i < linear_count_ + rotary_count_; ++i) {
      const double by = -joint_inverse_.row(i).dot(rows);
      if (i < linear_count_)
        move(linear_[static_cast<std::size_t>(i)], by);
      else
        turn(rotary_[static_cast<std::size_t>(i - linear_count_)], by);
    }
    return dq;
  }
  for (int i = 0; i < rotary_count_; ++i) {
    const double by = rotary_count_ <= 2 ? -rotary_inverse_.row(i).dot(r.direction)
                                         : -rotary_pseudo_.row(i).dot(r.direction);
    turn(rotary_[static_cast<std::size_t>(i)], by);
  }
  const Vec3 remaining = left.position;
  for (int i = 0; i < linear_count_; ++i) {
    const double by =
        square_ ? -linear_inverse_.row(i).dot(remaining) : -linear_pseudo_.row(i).dot(remaining);
    move(linear_[static_cast<std::size_t>(i)], by);
  }
  return dq;
}

}  // namespace abbe
