#include "abbe/chain/inverse.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "abbe/chain/correction_step.h"
#include "abbe/chain/frozen_chain.h"
#include "abbe/chain/plan_impl.h"
#include "abbe/chain/walk.h"

namespace abbe {
namespace {

using Commands = std::array<double, kMaxAxes>;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kSamePose = 1e-7;   // rad: rotary positions this close are one solution
constexpr double kReached = 1e-14;   // rad: no need to look for a closer direction
constexpr double kReachable = 2e-6;  // rad: what the digits of a pose file may leave on fewer than five axes
constexpr double kReachedPosition = 1e-8;  // mm
constexpr double kOnSingularity = 1e-9;    // determinant below which there is no side
constexpr double kDegenerate = 1e-6;       // sine or volume of a design that sets no direction or position
constexpr int kStartsPerAxis = 8;
constexpr int kMaxSteps = 60;

/// A nominal solution: commands, and how far it is from the start.
struct Candidate {
  Commands q{};
  double distance = 0;
  bool within_travel = true;
  Side side;
};

/// a . (c1 x c2) of the first two free rotary axes.
[[nodiscard]] Side side_of_columns(const Plan::Impl& plan, const CarriedColumns& c, AxisSet free) {
  std::array<int, 2> turning{};
  std::size_t count = 0;
  for (int i = 0; i < plan.axis_count; ++i) {
    if ((free & plan.rotary & (AxisSet{1} << i)) == 0) continue;
    if (count == turning.size()) return {};
    turning[count++] = i;
  }
  if (count < turning.size()) return {};
  const Vec3 first = c.tool_axis.col(turning[0]), second = c.tool_axis.col(turning[1]);
  const double determinant = c.v[0].dot(first.cross(second));
  if (!(std::abs(determinant) > kOnSingularity)) return {};
  return {determinant > 0 ? 1 : -1, std::abs(determinant)};
}

class InverseSolver {
 public:
  InverseSolver(const Plan& plan, const Tool& tool, const Vec3& position, const Vec3& direction,
                const Commands& start, AxisSet free)
      : plan_(plan.impl()), tool_(tool), position_(position), direction_(direction), start_(start) {
    for (int i = 0; i < plan_.axis_count; ++i) {
      if ((free & (AxisSet{1} << i)) == 0) continue;
      free_ |= AxisSet{1} << i;
      (plan_.machine->axis(i).type == AxisType::rotary ? rotary_ : linear_).push_back(i);
    }
  }

  /// All nominal solutions found, nearest first.
  [[nodiscard]] std::vector<Candidate> solve() {
    std::vector<Candidate> found;
    if (!closed_form(found)) {
      for (const Commands& from : starts()) {
        Commands q = from;
        if (aim(q) && reach(q)) add(q, found);
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
    return found;
  }

 private:
  void add(const Commands& q, std::vector<Candidate>& found) const {
    Candidate candidate = unwrap(q);
    candidate.side = side_of_columns(plan_, columns_at(candidate.q), free_);
    const bool known = std::any_of(found.begin(), found.end(),
                                   [&](const Candidate& other) { return same(other.q, candidate.q); });
    if (!known) found.push_back(candidate);
  }

  /// All solutions at once. False for chains it does not know everything about.
  [[nodiscard]] bool closed_form(std::vector<Candidate>& found) const {
    if (linear_.size() != 3 || rotary_.size() > 2) return false;
    Inputs<double> in;
    in.q = start_.data();
    in.tip = tool_.tip;
    FrozenChain chain;
    chain.freeze(plan_, plan_.nominal, in, free_, nullptr);
    const FrozenChain::Shape shape = chain.shape(start_, tool_.axis);
    if (!(shape.between_axes > kDegenerate) || !(shape.tool_to_axis > kDegenerate)) return false;
    const FrozenChain::Turns turns = chain.aim(start_, tool_.axis, direction_);
    for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(turns.count, 1)); ++i) {
      Commands q = start_;
      for (int r = 0; r < chain.rotary_count(); ++r)
        q[static_cast<std::size_t>(chain.rotary(r))] += turns.change[i][static_cast<std::size_t>(r)];
      chain.reach(q, position_);
      const CarriedColumns c = columns_at(q);
      if ((c.v[0] - direction_).norm() <= kReachable && (c.p - position_).norm() <= position_tolerance())
        add(q, found);
    }
    return true;
  }

  [[nodiscard]] double position_tolerance() const { return kReachedPosition + 1e-13 * position_.norm(); }

  [[nodiscard]] CarriedColumns columns_at(const Commands& q) const {
    Inputs<double> in;
    in.q = q.data();
    in.tip = tool_.tip;
    CarriedColumns c;
    c.v[0] = tool_.axis;
    walk_columns(plan_, in, c);
    return c;
  }

  /// The start itself, then a grid over whole turns of the first two rotary axes.
  [[nodiscard]] std::vector<Commands> starts() const {
    std::vector<Commands> all = {start_};
    const std::size_t axes = std::min<std::size_t>(rotary_.size(), 2);
    std::size_t count = 1;
    for (std::size_t i = 0; i < axes; ++i) count *= kStartsPerAxis;
    for (std::size_t n = 0; axes > 0 && n < count; ++n) {
      Commands q = start_;
      std::size_t digits = n;
      for (std::size_t i = 0; i < axes; ++i, digits /= kStartsPerAxis) {
        // An odd offset keeps the grid off the symmetric poses where the Jacobian vanishes.
        q[static_cast<std::size_t>(rotary_[i])] +=
            0.1 + kTurn * static_cast<double>(digits % kStartsPerAxis) / kStartsPerAxis;
      }
      all.push_back(q);
    }
    return all;
  }

  /// Levenberg-Marquardt on the rotary axes: min |a(q) - direction|^2. True if the direction is reached.
  [[nodiscard]] bool aim(Commands& q) const {
    CarriedColumns c = columns_at(q);
    double cost = (c.v[0] - direction_).squaredNorm();
    double damping = 1e-6;
    for (int step = 0; step < kMaxSteps && std::sqrt(cost) > kReached && !rotary_.empty(); ++step) {
      Commands next = q;
      const double size = add_damped_step(c, damping * cost + 1e-16, next);
      const CarriedColumns there = columns_at(next);
      const double next_cost = (there.v[0] - direction_).squaredNorm();
      if (next_cost < cost) {
        q = next;
        c = there;
        cost = next_cost;
        damping = std::max(damping * 0.2, 1e-9);
      } else {
        if (!(size > 1e-14) || damping > 1e12) break;
        damping *= 8;
      }
    }
    return std::sqrt(cost) <= kReachable;
  }

  /// dq = J^T (J J^T + lambda I)^-1 r in the plane across the present tool axis; returns its size.
  [[nodiscard]] double add_damped_step(const CarriedColumns& c, double lambda, Commands& q) const {
    Eigen::Index smallest = 0;
    c.v[0].cwiseAbs().minCoeff(&smallest);
    const Vec3 first = c.v[0].cross(Vec3(Vec3::Unit(smallest))).normalized(), second = c.v[0].cross(first);
    double a = lambda, b = 0, d = lambda;
    for (const int i : rotary_) {
      const double x = first.dot(c.tool_axis.col(i)), y = second.dot(c.tool_axis.col(i));
      a += x * x;
      b += x * y;
      d += y * y;
    }
    const double rx = first.dot(direction_), ry = second.dot(direction_), det = a * d - b * b;
    const double sx = (d * rx - b * ry) / det, sy = (a * ry - b * rx) / det;
    double size = 0;
    for (const int i : rotary_) {
      const double by =
          std::clamp(first.dot(c.tool_axis.col(i)) * sx + second.dot(c.tool_axis.col(i)) * sy, -1.0, 1.0);
      q[static_cast<std::size_t>(i)] += by;
      size = std::max(size, std::abs(by));
    }
    return size;
  }

  /// With the rotary axes in place the tip is affine in the linear ones: one least-squares step, and a
  /// second one for rounding.
  [[nodiscard]] bool reach(Commands& q) const {
    CorrectionStep step;
    AxisSet free = 0;
    for (const int i : linear_) free |= AxisSet{1} << i;
    for (int pass = 0; pass < 2; ++pass) {
      const CarriedColumns c = columns_at(q);
      step.prepare(plan_, c, direction_, free, {});
      Residual left;
      const Commands dq = step.solve({c.p - position_, Vec2(0, 0)}, left);
      for (std::size_t i = 0; i < dq.size(); ++i) q[i] += dq[i];
    }
    return (columns_at(q).p - position_).norm() <= position_tolerance();
  }

  /// Every rotary axis to the turn nearest to the start, within its travel if one fits.
  [[nodiscard]] Candidate unwrap(const Commands& q) const {
    Candidate c;
    c.q = q;
    double sum = 0;
    for (const int i : rotary_) {
      const auto k = static_cast<std::size_t>(i);
      c.q[k] += kTurn * std::round((start_[k] - c.q[k]) / kTurn);
      if (const auto& range = plan_.machine->axis(i).range; range.has_value() && !inside(i, c.q[k])) {
        const double turns = c.q[k] < (*range)[0] ? std::ceil(((*range)[0] - kSamePose - c.q[k]) / kTurn)
                                                  : -std::ceil((c.q[k] - (*range)[1] - kSamePose) / kTurn);
        if (inside(i, c.q[k] + turns * kTurn)) c.q[k] += turns * kTurn;
      }
      const double by = c.q[k] - start_[k];
      sum += by * by;
    }
    c.distance = std::sqrt(sum);
    for (const auto* axes : {&rotary_, &linear_}) {
      for (const int i : *axes)
        c.within_travel = c.within_travel && inside(i, c.q[static_cast<std::size_t>(i)]);
    }
    return c;
  }

  [[nodiscard]] bool inside(int axis, double q) const {
    const auto& range = plan_.machine->axis(axis).range;
    return !range.has_value() || (q >= (*range)[0] - kSamePose && q <= (*range)[1] + kSamePose);
  }

  [[nodiscard]] bool same(const Commands& a, const Commands& b) const {
    return std::all_of(rotary_.begin(), rotary_.end(), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      return std::abs(std::remainder(a[k] - b[k], kTurn)) < kSamePose;
    });
  }

  const Plan::Impl& plan_;
  const Tool& tool_;
  Vec3 position_, direction_;
  Commands start_;
  AxisSet free_ = 0;
  std::vector<int> linear_, rotary_;
};

void measure(InverseResult& result, const TipAndAxis& at, const Vec3& position, const Vec3& direction) {
  result.residual_position = (at.position - position).norm();
  result.residual_direction = std::atan2(at.tool_axis.cross(direction).norm(), at.tool_axis.dot(direction));
  if (!std::isfinite(result.residual_position) || !std::isfinite(result.residual_direction)) {
    result = InverseResult{};
  }
}

[[nodiscard]] TipAndAxis pose_at(const Plan& plan, const Query& query, bool ideal) {
  const Pose pose = ideal ? nominal_pose(plan, query) : actual_pose(plan, query);
  return {pose.p, pose.R * query.tool.axis};
}

}  // namespace

Side side_of(const Plan& plan, const Query& query, AxisSet free) {
  Inputs<double> in;
  in.q = query.q.data();
  in.tip = query.tool.tip;
  CarriedColumns c;
  c.v[0] = query.tool.axis;
  walk_columns(plan.impl(), in, c);
  return side_of_columns(plan.impl(), c, free);
}

InverseResult inverse(const Plan& plan, const Tool& tool, const Vec3& position, const Vec3& direction,
                      const std::array<double, kMaxAxes>& start, AxisSet free,
                      const InverseOptions& options) {
  InverseResult result;
  const double length = direction.norm();
  if (!position.allFinite() || !std::isfinite(length) || length <= 0 ||
      !std::all_of(start.begin(), start.end(), [](double x) { return std::isfinite(x); })) {
    return result;
  }
  const Vec3 unit = direction / length;
  const AxisSet moving = free & ~options.locked;
  const std::vector<Candidate> found = InverseSolver(plan, tool, position, unit, start, moving).solve();

  Query query;
  query.tool = tool;
  query.q = start;
  auto taken = std::find_if(found.begin(), found.end(), [&](const Candidate& c) {
    return c.within_travel && (options.side == 0 || c.side.sign == options.side);
  });
  if (taken == found.end())
    taken = std::find_if(found.begin(), found.end(), [](const Candidate& c) { return c.within_travel; });
  const bool reachable = taken != found.end();
  if (reachable)
    query.q = taken->q;
  else if (!found.empty())
    query.q = found.front().q;
  result.q = query.q;
  result.branch = reachable ? static_cast<int>(taken - found.begin()) : 0;
  if (reachable) result.side = taken->side;
  if (!reachable || options.ideal) {
    result.status = reachable ? Status::ok : Status::failed;
    measure(result, pose_at(plan, query, options.ideal), position, unit);
    return result;
  }
  CorrectOptions correction;
  correction.method = options.method;
  correction.max_rotary_correction = options.max_rotary_correction;
  const Correction corrected = correct(plan, query, moving, correction);
  result.q = corrected.corrected;
  result.status = corrected.status;
  result.iterations = corrected.iterations;
  result.outside = corrected.outside;
  query.q = corrected.corrected;
  measure(result, pose_at(plan, query, false), position, unit);
  return result;
}

}  // namespace abbe
