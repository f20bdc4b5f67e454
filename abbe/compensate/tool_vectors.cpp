#include "abbe/compensate/tool_vectors.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "abbe/core/units.h"

namespace abbe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kSmallestTilt = 1e-3;  // of the cone that the inner axis makes the tool describe
constexpr double kRounded = 1e-6;       // a direction this far beyond reach is reached but for its digits
constexpr double kAtPole = 1e-9;
// So near to the pole the outer axis is not turned for digits, rad.
constexpr double kPoleCone = 0.02 * deg;
constexpr double kStays = 0.5 * deg;
// A position is nearer if no axis goes farther by `kAlike`, and both together by `kClearly` less far.
constexpr double kAlike = 1 * deg, kClearly = 4 * deg;
constexpr double kSame = 1e-9;

Vec3 turned(const Vec3& axis, double angle, const Vec3& v) { return Eigen::AngleAxisd(angle, axis) * v; }

double nearest(double angle, double from) { return angle + kTurn * std::round((from - angle) / kTurn); }

}  // namespace

ToolVectors::ToolVectors(const Machine& machine, const AddressedAxes& axes) {
  const Machine believed = as_believed(machine);
  tool_ = believed.tool.axis;
  int count = 0;
  for (const Body& body : believed.bodies) {  // from the workpiece to the tool
    const auto at = std::find(axes.rotary.begin(), axes.rotary.end(), body.axis);
    if (body.axis < 0 || at == axes.rotary.end()) continue;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Axis& axis = count++ == 0 ? outer_ : inner_;
    axis.letter = static_cast<std::size_t>(at - axes.rotary.begin());
    axis.direction = (body.branch == Branch::tool ? 1 : -1) * body.direction;
    axis.travel = body.range.value_or(std::array<double, 2>{-infinity, infinity});
  }
  usable_ = count == 2;
}

Vec3 ToolVectors::vector_of(const Turns& turns) const {
  const Vec3 tilted = turned(inner_.direction, turns[inner_.letter], tool_);
  return turned(outer_.direction, turns[outer_.letter], tilted);
}

/// The outer axis turns the tilted tool to v:  tan r = n.(w x v) / w.v, both across n
std::optional<ToolVectors::Candidate> ToolVectors::candidate(const Vec3& v, double inner,
                                                             const Turns& from) const {
  const auto inside = [](double at, const std::array<double, 2>& travel) {
    return at >= travel[0] - kSame && at <= travel[1] + kSame;
  };
  const Vec3& n = outer_.direction;
  const Vec3 tilted = turned(inner_.direction, inner, tool_);
  const Vec3 w = tilted - n * n.dot(tilted), across = v - n * n.dot(v);
  const double stands = from[outer_.letter];
  Candidate found;
  found.inner = nearest(inner, from[inner_.letter]);
  found.outer = std::max(w.norm(), across.norm()) < kAtPole
                    ? stands
                    : nearest(std::atan2(n.dot(w.cross(across)), w.dot(across)), stands);
  found.near_pole = w.norm() < kPoleCone && std::abs(found.outer - stands) > kStays;
  if (!inside(found.inner, inner_.travel) || !inside(found.outer, outer_.travel)) return std::nullopt;
  return found;
}

ToolVectors::Trouble ToolVectors::choose(std::array<std::optional<Candidate>, 2>& found, const Turns& from,
                                         const Axis& outer, const Axis& inner) {
  if (!found[0] && !found[1]) return Trouble::travel;
  if (!found[0]) std::swap(found[0], found[1]);
  if (!found[1]) return Trouble::none;
  const auto way = [&](const Candidate& c) {
    return std::array{std::abs(c.outer - from[outer.letter]), std::abs(c.inner - from[inner.letter])};
  };
  if (way(*found[1])[0] + way(*found[1])[1] < way(*found[0])[0] + way(*found[0])[1])
    std::swap(found[0], found[1]);
  const auto near = way(*found[0]), far = way(*found[1]);
  const bool same = std::abs(found[0]->outer - found[1]->outer) < kSame &&
                    std::abs(found[0]->inner - found[1]->inner) < kSame;
  const bool nearer = near[0] <= far[0] + kAlike && near[1] <= far[1] + kAlike &&
                      near[0] + near[1] + kClearly < far[0] + far[1];
  return same || nearer ? Trouble::none : Trouble::several;
}

ToolVectors::Answer ToolVectors::turns_of(const Vec3& vector, const Turns& from) const {
  Answer answer{from, Trouble::axes};
  const double length = vector.norm();
  if (!usable_ || !(length > 0) || !std::isfinite(length)) return answer;
  const Vec3 v = vector / length;
  // n.v = A cos r + B sin r + C, the share along n that the tilt by r leaves
  const Vec3 &n = outer_.direction, &d = inner_.direction;
  const double C = n.dot(d) * d.dot(tool_), A = n.dot(tool_) - C, B = n.dot(d.cross(tool_));
  const double reach = std::hypot(A, B);
  if (reach < kSmallestTilt) return answer;
  const double cosine = (n.dot(v) - C) / reach;
  answer.trouble = Trouble::unreachable;
  if (!(std::abs(cosine) <= 1 + kRounded)) return answer;
  const double middle = std::atan2(B, A), spread = std::acos(std::clamp(cosine, -1.0, 1.0));
  std::array<std::optional<Candidate>, 2> found = {candidate(v, middle + spread, from),
                                                   candidate(v, middle - spread, from)};
  answer.trouble = choose(found, from, outer_, inner_);
  if (answer.trouble != Trouble::none) return answer;
  if (found[0]->near_pole) return answer.trouble = Trouble::pole, answer;
  answer.turns[outer_.letter] = found[0]->outer;
  answer.turns[inner_.letter] = found[0]->inner;
  return answer;
}

}  // namespace abbe
