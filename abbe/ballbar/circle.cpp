#include "abbe/ballbar/circle.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "abbe/core/least_squares.h"

namespace abbe {
namespace {

constexpr double kSameAngle = 1e-6;  // rad: closer points are one for the start of the exchange
constexpr double kTouches = 1e-13;   // relative to the largest deviation
constexpr int kMostExchanges = 2000;
constexpr int kGreedyExchanges = 500;  // then the first violation instead of the largest: no cycles

bool usable(std::span<const double> angle, std::span<const double> deviation) {
  if (angle.size() != deviation.size() || angle.size() < 3) return false;
  for (std::size_t i = 0; i < angle.size(); ++i)
    if (!std::isfinite(angle[i]) || !std::isfinite(deviation[i])) return false;
  return true;
}

void find_extremes(FittedCircle& circle, std::span<const double> angle, std::span<const double> deviation) {
  for (std::size_t i = 0; i < angle.size(); ++i) {
    const double r = deviation[i] - circle.x * std::cos(angle[i]) - circle.y * std::sin(angle[i]);
    circle.low = i == 0 ? r : std::min(circle.low, r);
    circle.high = i == 0 ? r : std::max(circle.high, r);
  }
}

/// max sum r_i (u_i - v_i)  with  sum u = 1, sum v = 1, sum (u - v) cos = 0, sum (u - v) sin = 0, u, v >= 0:
/// the dual of the zone. Its basis are the four points that touch; u_i touches outside, v_i inside.
class MinimumZone {
 public:
  MinimumZone(std::span<const double> angle, std::span<const double> deviation)
      : angle_(angle), deviation_(deviation) {
    double largest = 0;
    for (const double r : deviation) largest = std::max(largest, std::abs(r));
    tolerance_ = kTouches * largest;
  }

  /// The duals (high, -low, x, y) of the best basis, or nothing.
  bool solve(Eigen::Vector4d& zone) {
    if (!start()) return false;
    for (int step = 0; step < kMostExchanges; ++step) {
      const Eigen::Matrix4d basis = matrix();
      const Eigen::FullPivLU<Eigen::Matrix4d> lu(basis);
      if (!lu.isInvertible()) return false;
      Eigen::Vector4d cost;
      for (int k = 0; k < 4; ++k) cost[k] = value_of(basis_[static_cast<std::size_t>(k)]);
      // y^T B = c_B^T
      zone = basis.transpose().fullPivLu().solve(cost);
      const Column enters = violated(zone, step < kGreedyExchanges);
      if (enters.point == kNone) return true;
      // The weights of the basis must stay >= 0: the point whose weight vanishes first leaves.
      const Eigen::Vector4d weight = lu.solve(Eigen::Vector4d(1, 1, 0, 0));
      const Eigen::Vector4d change = lu.solve(column_of(enters));
      int leaves = -1;
      double least = 0;
      for (int k = 0; k < 4; ++k) {
        if (change[k] <= 1e-12) continue;
        const double ratio = std::max(weight[k], 0.0) / change[k];
        if (leaves < 0 || ratio < least) leaves = k, least = ratio;
      }
      if (leaves < 0) return false;
      basis_[static_cast<std::size_t>(leaves)] = enters;
    }
    return false;
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  struct Column {
    std::size_t point = kNone;
    bool outer = true;
  };

  /// Three points as far apart as they can be; the first one touches on both sides.
  bool start() {
    const auto farthest = [&](auto distance) {
      std::size_t best = 0;
      double most = -1;
      for (std::size_t i = 0; i < angle_.size(); ++i)
        if (const double d = distance(i); d > most) most = d, best = i;
      return std::pair{best, most};
    };
    const auto apart = [&](std::size_t i, std::size_t j) {
      return std::abs(std::sin((angle_[i] - angle_[j]) / 2));
    };
    const auto [second, d2] = farthest([&](std::size_t i) { return apart(i, 0); });
    const std::size_t other = second;
    const auto [third, d3] = farthest([&](std::size_t i) { return apart(i, 0) * apart(i, other); });
    basis_ = {Column{0, true}, Column{0, false}, Column{second, true}, Column{third, true}};
    return d2 > kSameAngle && d3 > kSameAngle * kSameAngle;
  }

  [[nodiscard]] Eigen::Vector4d column_of(const Column& c) const {
    const double cosine = std::cos(angle_[c.point]), sine = std::sin(angle_[c.point]);
    return c.outer ? Eigen::Vector4d(1, 0, cosine, sine) : Eigen::Vector4d(0, 1, -cosine, -sine);
  }
  [[nodiscard]] double value_of(const Column& c) const {
    return c.outer ? deviation_[c.point] : -deviation_[c.point];
  }
  [[nodiscard]] Eigen::Matrix4d matrix() const {
    Eigen::Matrix4d basis;
    for (int k = 0; k < 4; ++k) basis.col(k) = column_of(basis_[static_cast<std::size_t>(k)]);
    return basis;
  }

  /// The point farthest outside the zone (or the first one outside).
  [[nodiscard]] Column violated(const Eigen::Vector4d& zone, bool farthest) const {
    Column worst;
    double most = tolerance_;
    for (std::size_t i = 0; i < angle_.size(); ++i) {
      const double r = deviation_[i] - zone[2] * std::cos(angle_[i]) - zone[3] * std::sin(angle_[i]);
      const double above = r - zone[0], below = -r - zone[1];
      if (std::max(above, below) <= most) continue;
      worst = {i, above >= below};
      most = std::max(above, below);
      if (!farthest) return worst;
    }
    return worst;
  }

  std::span<const double> angle_, deviation_;
  double tolerance_ = 0;
  std::array<Column, 4> basis_;
};

}  // namespace

FittedCircle least_squares_circle(std::span<const double> angle, std::span<const double> deviation) {
  FittedCircle circle;
  if (!usable(angle, deviation)) return circle;
  TriangularFactor factor(3);
  for (std::size_t i = 0; i < angle.size(); ++i)
    factor.add(std::array{1.0, std::cos(angle[i]), std::sin(angle[i])}, deviation[i]);
  const LeastSquaresSolution fit = solve(factor, {});
  if (!fit.ok() || fit.rank < 3) return circle;
  circle.mean = fit.x[0];
  circle.x = fit.x[1];
  circle.y = fit.x[2];
  circle.found = true;
  find_extremes(circle, angle, deviation);
  return circle;
}

FittedCircle minimum_zone_circle(std::span<const double> angle, std::span<const double> deviation) {
  FittedCircle circle;
  Eigen::Vector4d zone = Eigen::Vector4d::Zero();
  if (!usable(angle, deviation) || !MinimumZone(angle, deviation).solve(zone) || !zone.allFinite())
    return circle;
  circle.x = zone[2];
  circle.y = zone[3];
  circle.found = true;
  find_extremes(circle, angle, deviation);
  circle.mean = (circle.low + circle.high) / 2;
  return circle;
}

}  // namespace abbe
