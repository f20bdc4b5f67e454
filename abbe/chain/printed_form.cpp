#include "abbe/chain/printed_form.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "abbe/chain/plan_impl.h"
#include "abbe/chain/predict.h"
#include "abbe/chain/query_variables.h"

namespace abbe {
namespace {

constexpr double kSame = 1e-9;       // mm and parts of a direction: a machine that is the one of the seed
constexpr double kRounding = 1e-12;  // beyond 1 an arc function's argument is rounding up to here
constexpr double kTurn = 2 * std::numbers::pi;

/// The axes of the chain in the order of the print.
enum Axis : std::size_t { kX, kC, kY, kZ, kA, kAxes };
constexpr std::array<std::string_view, kAxes> kNames = {"X", "C", "Y", "Z", "A"};
constexpr std::array<int, kAxes> kAlong = {0, 2, 1, 2, 0};  // component of the direction

[[nodiscard]] int axis_of(const Machine& machine, std::size_t axis) {
  return machine.find_axis(kNames[axis]);
}

[[nodiscard]] double sign_of(const Machine& machine, std::size_t axis) {
  return machine.axis(axis_of(machine, axis)).direction[kAlong[axis]] < 0 ? -1.0 : 1.0;
}

[[nodiscard]] std::optional<std::string> chain_obstacle(const Machine& machine, const Tool& tool) {
  static constexpr std::array<Branch, kAxes> kBranches = {Branch::workpiece, Branch::workpiece, Branch::tool,
                                                          Branch::tool, Branch::tool};
  static constexpr std::array<std::string_view, kAxes> kChain = {"C", "X", "Y", "Z", "A"};
  bool same = machine.bodies.size() == kAxes;
  for (std::size_t i = 0; same && i < kAxes; ++i) {
    const int axis = axis_of(machine, i);
    same = machine.bodies[i].name == kChain[i] && axis >= 0 && machine.axis(axis).branch == kBranches[i] &&
           (machine.axis(axis).type == AxisType::rotary) == (i == kC || i == kA);
  }
  if (!same) return "it is meant for the chain 'w C X b Y Z A t' only";
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Body& body = machine.axis(axis_of(machine, i));
    if (std::abs(std::abs(body.direction[kAlong[i]]) - 1) > kSame)
      return "the direction of " + body.name + " is not that of a coordinate axis";
    Vec3 origin = body.origin;
    if (i == kA) origin.z() = 0;
    if (origin.norm() > kSame)
      return "the origin of " + body.name + " is not at " + (i == kA ? "[0, 0, L]" : "[0, 0, 0]");
  }
  if (machine.workpiece_origin.norm() > kSame) return "the origin of the workpiece is not at [0, 0, 0]";
  if (tool.tip.norm() > kSame) return "the tip of the tool at home is not at [0, 0, 0]";
  if ((tool.axis - Vec3::UnitZ()).norm() > kSame) return "the tool axis is not [0, 0, 1]";
  return std::nullopt;
}

[[nodiscard]] bool is_printed(const ErrorName& name) {
  if (name.error_class == ErrorClass::component) return true;
  if (name.error_class != ErrorClass::location) return false;
  static constexpr std::array<std::string_view, 11> kLocation = {
      "EX0C", "EY0C", "EA0C", "EB0C", "EY0A", "EZ0A", "EB0A", "EC0A", "EC0Y", "EA0Z", "EB0Z"};
  return std::find(kLocation.begin(), kLocation.end(), to_string(name)) != kLocation.end();
}

[[nodiscard]] std::optional<std::string> error_obstacle(const Machine& machine) {
  for (const ErrorTerm& error : machine.errors) {
    if (!is_printed(error.name)) return to_string(error.name) + " is not among the 53 errors of the seed";
    if (error.body < 0) continue;
    const Body& body = machine.bodies[static_cast<std::size_t>(error.body)];
    const bool is_location = error.name.error_class == ErrorClass::location;
    const std::vector<Factor> printed = {{FactorKind::location, false},
                                         {FactorKind::motion, false},
                                         {FactorKind::component, false},
                                         {FactorKind::location, true}};
    const bool is_line = body.order == line_order(), is_frame = body.order == frame_order();
    const bool fits = body.name == "A"
                          ? body.order == printed || is_line || (!is_location && is_frame)
                          : is_frame || (!is_location && (is_line || body.order == after_order()));
    if (!fits) {
      return to_string(error.name) + " acts in another order than in the seed (" +
             (body.name == "A" ? "order = [\"location\", \"motion\", \"static\", \"-location\"]"
                               : "location = \"frame\"") +
             ")";
    }
  }
  return std::nullopt;
}

/// The errors under the names of the print: linear parts d, rotations e = (al, be, ga), per body, and
/// location errors with a 0.
struct PrintedErrors {
  Twist x, y, z, a, c, t, w, c0, a0, y0, z0;

  [[nodiscard]] Twist& of(const ErrorName& name) {
    const bool location = name.error_class == ErrorClass::location;
    switch (name.axis.front()) {
      case 'X':
        return x;
      case 'Y':
        return location ? y0 : y;
      case 'Z':
        return location ? z0 : z;
      case 'A':
        return location ? a0 : a;
      case 'C':
        return location ? c0 : c;
      case 't':
        return t;
      default:
        return w;
    }
  }
};

[[nodiscard]] PrintedErrors errors_at(const Plan::Impl& plan, const Query& query, bool* outside) {
  const Machine& machine = *plan.machine;
  const QueryVariables read = query_variables(plan, query);
  PrintedErrors errors;
  for (const ErrorTerm& error : machine.errors) {
    const double value =
        error.scale * error.function.value<double>(read.values.data(), read.approach.data(), outside);
    Twist& sum = errors.of(error.name);
    const int k = error.name.direction;
    (k < 3 ? sum.d[k] : sum.e[k - 3]) += value;
  }
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Body& body = machine.axis(axis_of(machine, i));
    Twist& sum = errors.of({ErrorClass::component, 0, body.name});
    // d = d_file - e x (measured_at - origin)
    if (body.measured_at.has_value()) sum.d -= sum.e.cross(*body.measured_at - body.origin);
    // The inverse of a small matrix: both signs turn.
    if (body.errors_seen_at_tool) sum = {-sum.d, -sum.e};
  }
  return errors;
}

/// near + whole turns, nearest to `to`.
[[nodiscard]] double nearest_turn(double angle, double to) {
  return angle + kTurn * std::round((to - angle) / kTurn);
}

}  // namespace

std::optional<std::string> printed_form_obstacle(const Machine& machine, const Tool& tool, AxisSet free) {
  if (auto obstacle = chain_obstacle(machine, tool)) return obstacle;
  if (free != (AxisSet{1} << kAxes) - 1) return "it moves all five axes";
  return error_obstacle(machine);
}

PrintedForm printed_form(const Plan& plan, const Query& query, const Vec3& target, const Vec3& axis,
                         AxisSet keep, bool* outside) {
  const Plan::Impl& impl = plan.impl();
  const Machine& machine = *impl.machine;
  std::array<std::size_t, kAxes> index{};
  std::array<double, kAxes> sign{}, commanded{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    index[i] = static_cast<std::size_t>(axis_of(machine, i));
    sign[i] = sign_of(machine, i);
    commanded[i] = sign[i] * query.q[index[i]];
  }
  const auto kept = [&](Axis which) { return (keep >> index[which] & 1U) != 0; };
  const double L = machine.axis(static_cast<int>(index[kA])).origin.z();
  const PrintedErrors E = errors_at(impl, query, outside);
  enum { x, y, z };
  enum { al, be, ga };
  const double xw = target.x(), yw = target.y(), zw = target.z();
  const double i = axis.x(), j = axis.y(), k = axis.z();

  // Direction. s = +1: A in (0, pi)
  const bool positive = std::sin(commanded[kA]) >= 0;
  const double gamma = E.a0.e[ga] - E.c.e[ga] - E.w.e[ga] - E.x.e[ga] + E.y0.e[ga] + E.y.e[ga] + E.z.e[ga];
  const double a = E.c.e[al] + E.w.e[al], b = E.c.e[be] + E.w.e[be];
  // P = i + G j + b k,  Q = G i - j + a k,  N = bT + bA - bAZ - (bCX - bAZ + bX - bY - bZX - bZ) k
  const double P = i + gamma * j + b * k, Q = gamma * i - j + a * k;
  const double N = E.t.e[be] + E.a.e[be] - E.a0.e[be] -
                   (E.c0.e[be] - E.a0.e[be] + E.x.e[be] - E.y.e[be] - E.z0.e[be] - E.z.e[be]) * k;
  const double radicand = i * i + j * j - 2 * j * k * a + 2 * i * k * b;
  const double ratio = N / std::sqrt(radicand), cosine = k - b * i + a * j;

  PrintedForm result;
  double C = commanded[kC], A = commanded[kA];
  result.singular = !(radicand > 0) || !(std::abs(ratio) <= 1) || !(std::abs(cosine) <= 1 + kRounding);
  if (!result.singular && !kept(kC)) {
    // C' = asin(N / sqrt(i^2 + j^2 - 2 j k a + 2 i k b)) - atan2(P, Q); s = -1: pi - asin(..) - atan2(P, Q)
    const double arc = std::asin(ratio);
    C = nearest_turn((positive ? arc : std::numbers::pi - arc) - std::atan2(P, Q), commanded[kC]);
  }
  if (!result.singular && !kept(kA)) {
    // A' = s acos(k - b i + a j) - (aA + aT + aY + aZY + aZ - aX - aCY)
    const double arc = std::acos(std::clamp(cosine, -1.0, 1.0));
    A = nearest_turn((positive ? arc : -arc) - (E.a.e[al] + E.t.e[al] + E.y.e[al] + E.z0.e[al] + E.z.e[al] -
                                                E.x.e[al] - E.c0.e[al]),
                     commanded[kA]);
  }

  const double cA = std::cos(A), sA = std::sin(A), cC = std::cos(C), sC = std::sin(C);
  // U1 = dWx + dCx(C) + x + b z - (gW + gC + gX) y,  U2 = dWy + dCy(C) + y - a z + (gW + gC + gX) x
  const double turn = E.w.e[ga] + E.c.e[ga] + E.x.e[ga];
  const double U1 = E.w.d[x] + E.c.d[x] + xw + b * zw - turn * yw;
  const double U2 = E.w.d[y] + E.c.d[y] + yw - a * zw + turn * xw;
  // K1 = dTy - dAy + dAy(A) + (aA + aT.. ) L
  const double alpha = E.a.e[al] + E.y.e[al] + E.z0.e[al] + E.z.e[al];
  const double K1 = E.t.d[y] - E.a0.d[y] + E.a.d[y] + alpha * L;
  const double Z = zw + E.w.d[z] - E.a0.d[z] - L + E.c.d[z] + E.x.d[z] - E.y.d[z] - E.z.d[z] + a * yw -
                   b * xw + (E.c0.e[al] + E.x.e[al]) * (yw * cC + xw * sC) -
                   (E.c0.e[be] + E.x.e[be]) * (xw * cC - yw * sC) - K1 * sA +
                   (L + E.a0.d[z] - E.t.d[z] - E.a.d[z]) * cA;
  const double Y = (E.t.d[z] - E.a0.d[z] - L + E.a.d[z]) * sA + E.c0.d[y] - E.a0.d[y] + E.x.d[y] - E.y.d[y] -
                   E.z.d[y] + (E.y.e[al] + E.z0.e[al] + E.z.e[al]) * L - K1 * cA -
                   (E.c0.e[al] + E.x.e[al]) * zw + U2 * cC + U1 * sC + (E.y.e[al] + E.z0.e[al]) * Z;
  const double beta = E.y.e[be] + E.z0.e[be] + E.z.e[be];
  const double X = -((E.a0.e[be] + beta) * L * cA + E.c0.d[x] - E.t.d[x] - E.a.d[x] + E.x.d[x] - E.y.d[x] -
                     E.z.d[x] + (E.a.e[be] - E.a0.e[be] - beta) * L + (E.c0.e[be] + E.x.e[be]) * zw +
                     U1 * cC - U2 * sC + (E.a0.e[ga] + E.y0.e[ga] + E.y.e[ga] + E.z.e[ga]) * L * sA) +
                   (E.y.e[be] + E.z0.e[be]) * Z - E.y0.e[ga] * Y;
  const std::array<double, kAxes> solved = {X, C, Y, Z, A};
  result.q = query.q;
  for (std::size_t n = 0; n < kAxes; ++n) result.q[index[n]] = sign[n] * solved[n];
  return result;
}

}  // namespace abbe
