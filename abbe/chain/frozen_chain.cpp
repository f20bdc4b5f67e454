#include "abbe/chain/frozen_chain.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/chain/pseudo_inverse.h"

namespace abbe {
namespace {

constexpr double kNothing = 1e-12;   // sine below which a direction lies on the axis that should turn it
constexpr double kRounding = 1e-12;  // |N| may exceed rho by this part: rounding, not a direction too far
constexpr double kRestored = 1e-15;  // a direction this near needs no turn: zero errors change nothing

/// x without its share along the unit vector u.
[[nodiscard]] Vec3 across(const Vec3& u, const Vec3& x) { return x - u * u.dot(x); }

/// The turn about u that brings b nearest to c; 0 if u cannot tell.
[[nodiscard]] double turn_between(const Vec3& u, const Vec3& b, const Vec3& c) {
  const Vec3 from = across(u, b), to = across(u, c);
  if (from.norm() <= kNothing || to.norm() <= kNothing) return 0;
  return std::atan2(u.dot(from.cross(to)), from.dot(to));
}

[[nodiscard]] double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

}  // namespace

void FrozenChain::freeze(const Plan::Impl& plan, std::span<const Op> ops, const Inputs<double>& in,
                         AxisSet free, bool* outside) {
  link_count_ = 0;
  rotary_count_ = 0;
  const auto start = [](const Vec3& p) {
    Carried<double, 3> c;
    c.v = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
    c.p = p;
    return c;
  };
  Carried<double, 3> c = start(Vec3::Zero());
  const auto close = [&] {
    Constant& constant = link_count_ == 0 ? base_ : links_[link_count_ - 1].after;
    constant.r << c.v[0], c.v[1], c.v[2];
    constant.t = c.p;
  };
  for (const Op& op : ops) {
    const bool moves = op.kind == Op::Kind::slide || op.kind == Op::Kind::turn;
    if (!moves || (free & (AxisSet{1} << op.axis)) == 0) {
      apply<double, 3>(plan, op, in, c, outside);
      continue;
    }
    close();
    Link& link = links_[link_count_];
    link.axis = op.axis;
    link.rotary = op.kind == Op::Kind::turn;
    link.u = op.u;
    if (link.rotary) rotary_[static_cast<std::size_t>(rotary_count_++)] = link_count_;
    ++link_count_;
    c = start(op.t);
  }
  close();
}

Mat3 FrozenChain::rotation(std::size_t first, std::size_t last) const {
  Mat3 r = Mat3::Identity();
  for (std::size_t i = first; i < last; ++i) r = (links_[i].after.r * r).eval();
  return r;
}

FrozenChain::Turns FrozenChain::aim(const Commands& q, const Vec3& tool_axis, const Vec3& target) const {
  if (rotary_count_ == 2) return aim_two(q, tool_axis, target);
  Turns turns;
  if (rotary_count_ != 1) return turns;
  const std::size_t link = rotary_[0];
  const Vec3& u = links_[link].u;
  const Vec3 b = rotation(0, link) * (base_.r * tool_axis);
  const Vec3 c = rotation(link, link_count_).transpose() * target;
  const Mat3 r = turn_matrix<double>(u, q[static_cast<std::size_t>(links_[link].axis)]);
  turns.count = 1;
  turns.resting = links_[link].axis;
  const Vec3 now = r * b;
  turns.change[0][0] = (now - c).norm() <= kRestored ? 0.0 : turn_between(u, now, c);
  return turns;
}

/// R_o Rot(k1, q1 + x1) M Rot(k, q2 + x2) b = target, k1 near the workpiece. With k2 = M k this is
///
///     Rot(k2, x2) g0 = Rot(k1, -x1) c,     g0 = Rot(k2, q2) M b,    c = Rot(k1, -q1) R_o^T target
///
/// The share along k2 does not know x2:   P cos x1 + Q sin x1 = N.
FrozenChain::Turns FrozenChain::aim_two(const Commands& q, const Vec3& tool_axis, const Vec3& target) const {
  const std::size_t inner = rotary_[0], outer = rotary_[1];
  const Link &near_tool = links_[inner], &near_work = links_[outer];
  const Mat3 middle = rotation(inner, outer);
  const Mat3 turned = turn_matrix<double>(near_tool.u, q[static_cast<std::size_t>(near_tool.axis)]);
  const Mat3 back = turn_matrix<double>(near_work.u, -q[static_cast<std::size_t>(near_work.axis)]);
  const Vec3& k1 = near_work.u;
  const Vec3 k2 = middle * near_tool.u;
  const Vec3 g0 = middle * (turned * (rotation(0, inner) * (base_.r * tool_axis)));
  const Vec3 c = back * (rotation(outer, link_count_).transpose() * target);

  Turns turns;
  turns.count = 1;
  turns.resting = k1.cross(c).squaredNorm() < k2.cross(g0).squaredNorm() ? near_work.axis : near_tool.axis;
  if ((g0 - c).norm() <= kRestored) return turns;
  const Vec3 c_across = across(k1, c);
  // P cos x1 + Q sin x1 = N
  const double p = k2.dot(c_across), q_sine = -k2.dot(k1.cross(c)), n = k2.dot(g0) - k1.dot(k2) * k1.dot(c);
  const double rho = std::hypot(p, q_sine);
  if (rho <= kNothing || std::abs(n) > rho * (1 + kRounding)) turns.kind = Turns::Kind::out_of_reach;
  // The axis that turns the tool about itself keeps its command.
  const double middle_turn = rho <= kNothing ? 0.0 : std::atan2(q_sine, p);
  // acos(N / rho), from its sine too: exact where the two solutions meet
  const double half = rho <= kNothing ? 0.0 : std::atan2(std::sqrt(std::max(0.0, (rho - n) * (rho + n))), n);
  turns.count = rho <= kNothing ? 1 : 2;
  for (std::size_t i = 0; i < static_cast<std::size_t>(turns.count); ++i) {
    const double x1 = wrapped(middle_turn + (i == 0 ? half : -half));
    const Vec3 g = turn_matrix<double>(k1, -x1) * c;
    turns.change[i] = {turn_between(k2, g0, g), x1};
  }
  const auto size = [](const std::array<double, 2>& x) { return std::abs(x[0]) + std::abs(x[1]); };
  if (turns.count == 2 && size(turns.change[1]) < size(turns.change[0]))
    std::swap(turns.change[0], turns.change[1]);
  return turns;
}

FrozenChain::Affine FrozenChain::affine(const Commands& q) const {
  Affine a;
  a.tip = base_.t;
  for (std::size_t i = 0; i < link_count_; ++i) {
    const Link& link = links_[i];
    const double at = q[static_cast<std::size_t>(link.axis)];
    Mat3 r = link.after.r;
    if (link.rotary) {
      r = (r * turn_matrix<double>(link.u, at)).eval();
    } else {
      a.tip += link.u * at;
      a.axis[a.count] = link.axis;
      a.column[a.count++] = link.u;
    }
    a.tip = (r * a.tip + link.after.t).eval();
    for (std::size_t k = 0; k < a.count; ++k) a.column[k] = (r * a.column[k]).eval();
  }
  return a;
}

int FrozenChain::reach(Commands& q, const Vec3& target) const {
  const Affine a = affine(q);
  const Vec3 missing = target - a.tip;
  if (a.count == 0) return 0;
  const auto move = [&](std::size_t k, double by) { q[static_cast<std::size_t>(a.axis[k])] += by; };
  if (a.count == 3) {
    // [a b c] dq = missing by cross products
    const Vec3 bc = a.column[1].cross(a.column[2]);
    const double volume = a.column[0].dot(bc);
    if (std::abs(volume) > kDependentAxes) {
      move(0, bc.dot(missing) / volume);
      move(1, a.column[2].cross(a.column[0]).dot(missing) / volume);
      move(2, a.column[0].cross(a.column[1]).dot(missing) / volume);
      return 3;
    }
  }
  SmallMatrix j;
  j.rows = 3;
  j.count = static_cast<int>(a.count);
  for (std::size_t k = 0; k < a.count; ++k)
    j.columns[k] = {a.column[k].x(), a.column[k].y(), a.column[k].z()};
  int rank = 0;
  const SmallMatrix inverse = pseudo_inverse(j, rank, a.count == 3 ? kDependentAxes : 1e-7);
  for (std::size_t k = 0; k < a.count; ++k) {
    const SmallMatrix::Column& row = inverse.columns[k];
    move(k, row[0] * missing.x() + row[1] * missing.y() + row[2] * missing.z());
  }
  return rank;
}

FrozenChain::Shape FrozenChain::shape(const Commands& q, const Vec3& tool_axis) const {
  Shape shape;
  if (rotary_count_ == 2) {
    const std::size_t inner = rotary_[0], outer = rotary_[1];
    shape.between_axes = (rotation(inner, outer) * links_[inner].u).cross(links_[outer].u).norm();
    shape.tool_to_axis = (rotation(0, inner) * (base_.r * tool_axis)).cross(links_[inner].u).norm();
  }
  const Affine a = affine(q);
  if (a.count == 3) shape.volume = std::abs(a.column[0].dot(a.column[1].cross(a.column[2])));
  return shape;
}

}  // namespace abbe
