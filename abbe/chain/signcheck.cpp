#include "abbe/chain/signcheck.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "abbe/chain/plan_impl.h"
#include "abbe/chain/walk.h"

namespace abbe {
namespace {

using Commands = std::array<double, kMaxAxes>;

constexpr double kVisibleLength = 1e-6;  // mm: a nanometre is no reading
constexpr double kVisibleAngle = 1e-9;   // rad
constexpr int kDivisions = 8;            // of the travel; a test move covers two of them

struct Reading {
  Vec3 position, rotation;  ///< deviation by the one error, workpiece axes
  Vec3 tip;                 ///< nominal
};

class Checker {
 public:
  Checker(const Plan& plan, int error)
      : machine_(plan.machine()),
        error_(machine_.errors[static_cast<std::size_t>(error)]),
        alone_(compile_plan(plan.impl().machine, plan.impl().variables, ErrorModel::first_order, error)),
        tool_(tool_of(machine_)) {}

  [[nodiscard]] SignCheck check() const {
    SignCheck best;
    best.error = to_string(error_.name);
    const int own = error_.body >= 0 ? machine_.bodies[static_cast<std::size_t>(error_.body)].axis : -1;
    for (const bool aside : {false, true}) {
      if (own >= 0) consider(own, aside, best);
      if (best.axis >= 0) break;
      for (int i = 0; i < machine_.axis_count(); ++i) consider(i, aside, best);
      if (best.axis >= 0) break;
    }
    best.words = words(best);
    return best;
  }

 private:
  [[nodiscard]] std::array<double, 2> travel(int axis) const {
    const Body& body = machine_.axis(axis);
    const double reach = body.type == AxisType::rotary ? std::numbers::pi : 250.0;
    return body.range.value_or(std::array<double, 2>{-reach, reach});
  }

  /// Zero where the travel allows it, else mid travel; `aside`: a quarter of the travel beyond.
  [[nodiscard]] Commands base(bool aside) const {
    Commands q{};
    for (int i = 0; i < machine_.axis_count(); ++i) {
      const auto [lo, hi] = travel(i);
      const double rest = lo <= 0 && hi >= 0 ? 0.0 : 0.5 * (lo + hi);
      q[static_cast<std::size_t>(i)] = aside ? std::min(rest + 0.2 * (hi - lo), hi) : rest;
    }
    return q;
  }

  [[nodiscard]] Reading read(const Commands& q) const {
    Query query;
    query.q = q;
    query.tool = tool_;
    const QueryInputs inputs(alone_.impl(), query);
    CarriedTwist<double, 0> c;
    bool outside = false;
    walk_first_order<double, 0>(alone_.impl(), inputs.inputs(), c, &outside);
    return {c.dp, c.e, c.p};
  }

  [[nodiscard]] static double score(const Vec3& position, const Vec3& rotation) {
    return std::max(position.norm() / kVisibleLength, rotation.norm() / kVisibleAngle);
  }

  void consider(int axis, bool aside, SignCheck& best) const {
    const auto [lo, hi] = travel(axis);
    const Commands at = base(aside);
    double most = best.axis >= 0 ? score(best.position, best.rotation) : 1.0;
    for (int k = 0; k + 2 <= kDivisions; ++k) {
      Commands a = at, b = at;
      a[static_cast<std::size_t>(axis)] = lo + (hi - lo) * k / kDivisions;
      b[static_cast<std::size_t>(axis)] = lo + (hi - lo) * (k + 2) / kDivisions;
      const Reading start = read(a), end = read(b);
      const Vec3 position = end.position - start.position, rotation = end.rotation - start.rotation;
      const double s = score(position, rotation);
      // Of equal moves the first: only a clear gain is worth another one.
      if (!std::isfinite(s) || s <= most * (1 + 1e-9)) continue;
      most = s;
      best.axis = axis;
      best.from = a[static_cast<std::size_t>(axis)];
      best.to = b[static_cast<std::size_t>(axis)];
      best.pose = a;
      best.travel = end.tip - start.tip;
      best.position = position;
      best.rotation = rotation;
    }
  }

  [[nodiscard]] std::string command(int axis, double q) const {
    const bool rotary = machine_.axis(axis).type == AxisType::rotary;
    return fmt::format("{:.6g} {}", rotary ? q / deg + 0.0 : q + 0.0, rotary ? "deg" : "mm");
  }

  [[nodiscard]] std::string words(const SignCheck& c) const {
    if (c.axis < 0) {
      return fmt::format(
          "{}: no slow move of one axis shows this error. A constant shift of the tool needs a "
          "datum, a dynamic error motion, a thermal error the temperature at which it was stated.",
          c.error);
    }
    std::string others;
    for (int i = 0; i < machine_.axis_count(); ++i) {
      if (i != c.axis)
        others += fmt::format("{}{} {}", others.empty() ? "" : ", ", machine_.axis(i).name,
                              command(i, c.pose[static_cast<std::size_t>(i)]));
    }
    std::string text = fmt::format("{}: move {} from {} to {}", c.error, machine_.axis(c.axis).name,
                                   command(c.axis, c.from), command(c.axis, c.to));
    if (!others.empty()) text += fmt::format(" ({})", others);
    text += ". ";
    if (c.position.norm() >= kVisibleLength) text += position_words(c);
    if (c.rotation.norm() >= kVisibleAngle) text += rotation_words(c);
    return text;
  }

  [[nodiscard]] static std::string position_words(const SignCheck& c) {
    Eigen::Index k = 0;
    c.position.cwiseAbs().maxCoeff(&k);
    const char letter = "XYZ"[k];
    const double reading = c.position(k) / um;
    const char* more = reading > 0 ? "more" : "less";
    // Across the nominal travel a dial on a straightedge reads the error itself; along it the travel has
    // to be measured.
    if (std::abs(c.travel(k)) <= 1e-3 * std::max(c.travel.norm(), 1.0)) {
      return fmt::format(
          "A dial on the table touching the spindle in +{} reads {:.2f} um {} at the end: the tool moves "
          "{:+.2f} um "
          "in {} of the workpiece. ",
          letter, std::abs(reading), more, reading, letter);
    }
    return fmt::format(
        "The travel of the tool in {} of the workpiece, {:.4f} mm as commanded, is measured {:.2f} um {} "
        "(towards +{}). ",
        letter, c.travel(k), std::abs(reading), more, letter);
  }

  [[nodiscard]] static std::string rotation_words(const SignCheck& c) {
    Eigen::Index k = 0;
    c.rotation.cwiseAbs().maxCoeff(&k);
    return fmt::format(
        "A level or autocollimator on the spindle, against the table, turns by {:+.2f} urad about +{} "
        "of the workpiece (right hand). ",
        c.rotation(k) / urad, "XYZ"[k]);
  }

  const Machine& machine_;
  const ErrorTerm& error_;
  Plan alone_;
  Tool tool_;
};

}  // namespace

std::vector<SignCheck> sign_checks(const Plan& plan) {
  std::vector<SignCheck> checks;
  for (int i = 0; i < static_cast<int>(plan.machine().errors.size()); ++i)
    checks.push_back(Checker(plan, i).check());
  for (SignCheck& check : checks) {
    while (!check.words.empty() && check.words.back() == ' ') check.words.pop_back();
  }
  return checks;
}

}  // namespace abbe
