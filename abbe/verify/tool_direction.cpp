#include "abbe/verify/tool_direction.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "abbe/core/units.h"

namespace abbe::verifying {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;
constexpr double kModel = 1e-9;       // what probes of a machine of two rotary axes may disagree by
constexpr double kLeastSwing = 1e-3;  // else the fast axis does not tilt the tool
constexpr double kDigits = 1e-6;      // a direction may be out of reach by its digits
constexpr double kOnPivot = 1e-9;
constexpr double kNearPivot = 0.02 * deg, kFarTurn = 0.5 * deg;
constexpr double kLittle = 1 * deg, kMuch = 4 * deg;
constexpr double kOne = 1e-9;  // positions that are one, rad

/// The whole turns added that bring an angle next to where an axis stands.
double beside(double angle, double stands) { return stands + std::remainder(angle - stands, 4 * kQuarter); }

}  // namespace

ToolDirection::ToolDirection(const Machine& machine, const AddressedAxes& axes,
                             const ControlKinematics& kinematics)
    : nearest_(machine.control.vectors.nearest) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<std::size_t, 3> letters{};
  std::size_t count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    travel_[k] = {-infinity, infinity};
    if (axes.rotary[k] < 0) continue;
    letters[count++] = k;
    travel_[k] = machine.axis(axes.rotary[k]).range.value_or(travel_[k]);
  }
  known_ =
      count == 2 && (learn(letters[0], letters[1], kinematics) || learn(letters[1], letters[0], kinematics));
}

/// False: `slow` is not the one that turns the whole cone of the other.
bool ToolDirection::learn(std::size_t slow, std::size_t fast, const ControlKinematics& kinematics) {
  const Tool tool = tool_of(kinematics.believed(), 0);
  const auto axis_at = [&](double slow_turn, double fast_turn) {
    Turns turns{};
    turns[slow] = slow_turn;
    turns[fast] = fast_turn;
    return Vec3(kinematics.pose(Vec3::Zero(), turns, tool).tool_axis.normalized());
  };
  slow_ = slow;
  fast_ = fast;
  steady_ = (axis_at(0, 0) + axis_at(0, 2 * kQuarter)) / 2;
  swing_ = axis_at(0, 0) - steady_;
  sweep_ = axis_at(0, kQuarter) - steady_;
  // Two chords of the circle that a tilted tool describes are across p; which of its circles is large enough?
  double largest = 0;
  for (const double fast_turn : {0.0, kQuarter, -kQuarter}) {
    const Vec3 here = axis_at(0, fast_turn), on = axis_at(kQuarter, fast_turn),
               beyond = axis_at(2 * kQuarter, fast_turn);
    const Vec3 normal = (on - here).cross(beyond - on);
    if (normal.norm() <= largest) continue;
    largest = normal.norm();
    pivot_ = normal / largest;
  }
  if (largest < kLeastSwing * kLeastSwing) return false;
  const double some = 0.7, other = -1.1;  // rad, any
  const Vec3 expected = Eigen::AngleAxisd(some, pivot_) * axis_at(0, other);
  const Vec3 cone = steady_ + swing_ * std::cos(other) + sweep_ * std::sin(other);
  return (axis_at(some, other) - expected).norm() < kModel && (axis_at(0, other) - cone).norm() < kModel;
}

bool ToolDirection::within(std::size_t letter, double turn) const {
  return turn >= travel_[letter][0] - kOne && turn <= travel_[letter][1] + kOne;
}

ToolDirection::Found ToolDirection::turns_for(const Vec3& direction, const Turns& from) const {
  Found best{from, "the machine has no two rotary axes whose positions follow from a direction"};
  if (!known_ || !nearest_) return best;
  const double size = direction.norm();
  best.problem = "a direction of no length";
  if (!(size > 0) || !std::isfinite(size)) return best;
  const Vec3 wanted = direction / size;
  // height of the wanted axis over the middle of the sine, in its amplitude
  const double h1 = pivot_.dot(swing_), h2 = pivot_.dot(sweep_), amplitude = std::hypot(h1, h2);
  const double height = amplitude < kLeastSwing ? 2 : pivot_.dot(wanted - steady_) / amplitude;
  best.problem = "a direction that the rotary axes do not reach";
  if (!(std::abs(height) <= 1 + kDigits)) return best;

  best.problem = "a direction that is reached only beyond the travels";
  const double bound = std::min(1.0, std::max(-1.0, height));
  double best_way = std::numeric_limits<double>::infinity();
  bool unsure = false, turns_far_for_little = false;
  const std::size_t slow = slow_, fast = fast_;
  const auto way = [&](const Turns& to, std::size_t k) { return std::abs(to[k] - from[k]); };
  for (const double side : {1.0, -1.0}) {
    Turns turns = from;
    turns[fast] = beside(std::atan2(h2, h1) + side * std::acos(bound), from[fast]);
    const Vec3 tilted = steady_ + swing_ * std::cos(turns[fast]) + sweep_ * std::sin(turns[fast]);
    const Vec3 radius = tilted - pivot_ * pivot_.dot(tilted), to = wanted - pivot_ * pivot_.dot(wanted);
    const Vec3 aside = pivot_.cross(radius);
    if (radius.norm() >= kOnPivot || to.norm() >= kOnPivot)
      turns[slow] = beside(std::atan2(aside.dot(to), radius.dot(to)), from[slow]);
    if (!within(slow, turns[slow]) || !within(fast, turns[fast])) continue;
    const double total = way(turns, slow) + way(turns, fast);
    const bool new_best = total < best_way;
    const bool one = best.problem == nullptr && std::abs(turns[slow] - best.turns[slow]) < kOne &&
                     std::abs(turns[fast] - best.turns[fast]) < kOne;
    if (best.problem == nullptr && !one) {
      const Turns &nearer = new_best ? turns : best.turns, &farther = new_best ? best.turns : turns;
      unsure = std::abs(total - best_way) <= kMuch || way(nearer, slow) > way(farther, slow) + kLittle ||
               way(nearer, fast) > way(farther, fast) + kLittle;
    }
    if (new_best) {
      best_way = total;
      best = {turns, nullptr};
      turns_far_for_little = radius.norm() < kNearPivot && way(turns, slow) > kFarTurn;
    }
  }
  if (unsure) best.problem = "a direction that two positions give, none of them clearly the nearer";
  if (turns_far_for_little)
    best.problem = "a direction that turns an axis far although the tool hardly tilts";
  return best;
}

}  // namespace abbe::verifying
