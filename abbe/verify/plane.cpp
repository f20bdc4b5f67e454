#include "abbe/verify/plane.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace abbe::verifying {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kMostRounds = 400;
constexpr double kStill = 1e-14;       // rad: no axis moves any more
constexpr double kAlong = 1e-9;        // rad off the normal: rounding
constexpr double kNoInfluence = 1e-7;  // of an axis on the direction
constexpr double kSameWay = 1e-6;      // rad

Vec3 direction(const Rotary& rotary, const Turns& turns) {
  const ControlKinematics& kinematics = rotary.kinematics();
  return kinematics.pose(Vec3::Zero(), turns, tool_of(kinematics.believed())).tool_axis;
}

/// The normal in workpiece axes.
Vec3 on_workpiece(const Rotary& rotary, const Vec3& normal) {
  const ControlKinematics& kinematics = rotary.kinematics();
  return (kinematics.tip_of_axes(Turns{}, tool_of(kinematics.believed())).A * normal).normalized();
}

double next_to(double angle, double from) { return angle + kTurn * std::round((from - angle) / kTurn); }

/// Axis k alone: where the tool is nearest to `normal` (workpiece axes).
double nearest(const Rotary& rotary, const Vec3& normal, Turns turns, std::size_t k) {
  const double from = turns[k];
  double cosine = 0, sine = 0;
  for (int i = 0; i < 3; ++i) {
    turns[k] = from + kTurn * i / 3;
    const double share = direction(rotary, turns).dot(normal) * 2 / 3;
    cosine += share * std::cos(kTurn * i / 3);
    sine += share * std::sin(kTurn * i / 3);
  }
  return std::hypot(cosine, sine) < kNoInfluence ? from : from + std::atan2(sine, cosine);
}

/// The only turns of an axis that counts them within its travel; of the others the shorter way.
std::optional<double> counted(const Rotary& rotary, int k, double angle, double from) {
  if (rotary.turning(k) != Turning::linear) return next_to(angle, from);
  const Machine& machine = rotary.kinematics().believed();
  const auto& range = machine.axis(rotary.axes().rotary[static_cast<std::size_t>(k)]).range;
  if (!range) return std::nullopt;
  int ways = 0;
  double way = 0;
  constexpr int most = 30;
  for (int turn = -most; turn <= most; ++turn) {
    const double place = angle + turn * kTurn;
    if (place < (*range)[0] - kSameWay || place > (*range)[1] + kSameWay) continue;
    way = place;
    ++ways;
  }
  return ways == 1 ? std::optional<double>(way) : std::nullopt;
}

bool same_way(const Turns& a, const Turns& b) {
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(next_to(a[k], b[k]) - b[k]) > kSameWay) return false;
  return true;
}

}  // namespace

double askew(const Rotary& rotary, const Vec3& normal, const Turns& turns) {
  const Vec3 is = direction(rotary, turns), wanted = on_workpiece(rotary, normal);
  return std::atan2(is.cross(wanted).norm(), is.dot(wanted));
}

std::optional<Turns> laid_along(const Rotary& rotary, const Vec3& normal, Turns from) {
  const Vec3 wanted = on_workpiece(rotary, normal);
  for (int round = 0; round < kMostRounds; ++round) {
    double moved = 0;
    for (int k = 0; k < 3; ++k) {
      if (!rotary.has(k)) continue;
      const auto i = static_cast<std::size_t>(k);
      const double to = nearest(rotary, wanted, from, i);
      moved = std::max(moved, std::abs(to - from[i]));
      from[i] = to;
    }
    if (moved < kStill) break;
  }
  return askew(rotary, normal, from) < kAlong ? std::optional<Turns>(from) : std::nullopt;
}

std::optional<Turns> laid_on_side(const Rotary& rotary, const Vec3& normal, const Turns& from,
                                  const TiltSolution& side) {
  const auto chosen = static_cast<std::size_t>(side.axis);
  if (!rotary.has(side.axis)) return std::nullopt;
  std::optional<Turns> way;
  constexpr int starts = 7;
  for (int i = 0; i < starts * starts; ++i) {
    Turns start{};
    for (std::size_t k = 0; k < 3; ++k)
      if (rotary.has(static_cast<int>(k)))
        start[k] = kTurn * ((k == chosen ? i / starts : i % starts) + 0.2) / starts - kTurn / 2;
    const auto laid = laid_along(rotary, normal, start);
    if (!laid) continue;
    const double at = next_to((*laid)[chosen], 0);
    if (std::abs(at) < kSameWay)
      return askew(rotary, normal, from) < kSameWay ? laid_along(rotary, normal, from) : std::nullopt;
    if (at * side.sign < 0 || (way && same_way(*laid, *way))) continue;
    if (way) return std::nullopt;
    way = laid;
  }
  for (int k = 0; way && k < 3; ++k) {
    if (!rotary.has(k)) continue;
    const auto i = static_cast<std::size_t>(k);
    const auto place = counted(rotary, k, (*way)[i], from[i]);
    if (!place) return std::nullopt;
    (*way)[i] = *place;
  }
  return way;
}

}  // namespace abbe::verifying
