#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "abbe/machine/error_section.h"

// What the axes and the errors of a machine say together.

namespace abbe {
namespace {

/// The largest linear trend that a straightness may have beside a squareness of the same pair.
constexpr double kSlopeLimit = 1 * urad;

std::vector<std::string> names_of(const Machine& machine, const std::vector<std::size_t>& terms) {
  std::vector<std::string> names;
  for (const std::size_t i : terms) names.push_back(to_string(machine.errors[i].name));
  return names;
}

void require_errors_seen(const Machine& machine, const std::vector<AxisNotes>& axes, Findings& findings) {
  for (std::size_t i = 0; i < machine.bodies.size(); ++i) {
    if (!machine.bodies[i].errors_have_no_sign()) continue;
    std::vector<std::size_t> terms;
    for (std::size_t k = 0; k < machine.errors.size(); ++k) {
      const ErrorTerm& term = machine.errors[k];
      if (term.body == static_cast<int>(i) && term.name.error_class != ErrorClass::location)
        terms.push_back(k);
    }
    if (terms.empty()) continue;
    const std::string& name = machine.bodies[i].name;
    findings.error(
        "E-ERRORS-SEEN", axes[i].mark,
        fmt::format("axis {} carries the workpiece and has errors, but no errors_seen", name),
        fmt::format("{}: an error of the table itself and the error of the tool seen from the work have "
                    "opposite signs",
                    listed(names_of(machine, terms), "and")),
        fmt::format("add errors_seen = \"body\" (motion of the table was measured) or \"tool\" (tool "
                    "relative to the work) to [axis.{}]",
                    name));
  }
}

void warn_of_left_out(const Machine& machine, const std::vector<AxisNotes>& axes, Findings& findings) {
  for (std::size_t i = 0; i < machine.bodies.size(); ++i) {
    if (!axes[i].explicit_order) continue;
    std::vector<std::size_t> terms;
    for (std::size_t k = 0; k < machine.errors.size(); ++k) {
      const ErrorTerm& term = machine.errors[k];
      if (term.body == static_cast<int>(i) && !carries(machine.bodies[i], term.name)) terms.push_back(k);
    }
    if (terms.empty()) continue;
    findings.warning(
        "W-ORDER-LEAVES-OUT", axes[i].order,
        fmt::format("{} of axis {} {} no effect", listed(names_of(machine, terms), "and"),
                    machine.bodies[i].name, terms.size() == 1 ? "has" : "have"),
        "the explicit order names no factor that carries them",
        "add location (or along and across), static, thermal or dynamic to the order, or remove the "
        "errors");
  }
}

/// The bed axis that a linear axis moves along, if it is one.
std::optional<int> main_direction(const Body& body) {
  if (body.type != AxisType::linear) return std::nullopt;
  constexpr double kAlongOneAxis = 0.9;
  int main = 0;
  const double largest = body.direction.cwiseAbs().maxCoeff(&main);
  if (largest < kAlongOneAxis) return std::nullopt;
  return main;
}

/// The squareness given for the pair (axis, direction): E rotation 0 of this axis, or of a linear axis
/// along that direction. EYX: EC0X or EC0Y.
const ErrorTerm* squareness_of_pair(const Machine& machine, int body, int axis_direction,
                                    int error_direction) {
  const int rotation = 3 + (3 - axis_direction - error_direction);
  for (const ErrorTerm& term : machine.errors) {
    if (term.name.error_class != ErrorClass::location || term.name.direction != rotation || term.body < 0)
      continue;
    if (term.body == body ||
        main_direction(machine.bodies[static_cast<std::size_t>(term.body)]) == error_direction) {
      return &term;
    }
  }
  return nullptr;
}

/// Least-squares slope of the error over lo..hi of its axis, other variables zero; rad.
double trend(const Machine& machine, const ErrorTerm& term, int axis, double lo, double hi) {
  constexpr int kSamples = 101;
  std::vector<double> variables(machine.variables.size(), 0.0);
  const std::vector<signed char> approach(machine.variables.size(), 0);
  // slope = sum (v - mean) e / sum (v - mean)^2
  double numerator = 0;
  double denominator = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double t = -1 + 2.0 * i / (kSamples - 1);  // v = middle + t * half
    variables[static_cast<std::size_t>(axis)] = 0.5 * (lo + hi) + t * 0.5 * (hi - lo);
    numerator += t * term.function.value<double>(variables.data(), approach.data(), nullptr);
    denominator += t * t;
  }
  return numerator / denominator / (0.5 * (hi - lo)) * term.scale / machine.axis_unit(axis);
}

void warn_of_slope(const Machine& machine, const std::vector<ErrorNotes>& errors, Findings& findings) {
  for (std::size_t k = 0; k < machine.errors.size(); ++k) {
    const ErrorTerm& term = machine.errors[k];
    if (term.name.error_class != ErrorClass::component || term.name.is_rotation() || term.body < 0) continue;
    const Body& body = machine.bodies[static_cast<std::size_t>(term.body)];
    const auto main = main_direction(body);
    if (!main || *main == term.name.direction) continue;
    if (term.function.variables() != std::vector<int>{body.axis}) continue;
    const ErrorTerm* squareness = squareness_of_pair(machine, term.body, *main, term.name.direction);
    if (squareness == nullptr) continue;
    // Over what was measured, as far as it is travelled; a polynomial without either near zero.
    const double unit = machine.axis_unit(body.axis);
    double lo = -1;
    double hi = 1;
    if (errors[k].extent) {
      lo = (*errors[k].extent)[0];
      hi = (*errors[k].extent)[1];
    }
    if (body.range) {
      const double from = (*body.range)[0] / unit;
      const double to = (*body.range)[1] / unit;
      const bool apart = errors[k].extent && (from >= hi || to <= lo);
      lo = errors[k].extent && !apart ? std::max(lo, from) : from;
      hi = errors[k].extent && !apart ? std::min(hi, to) : to;
    }
    if (!(lo < hi)) continue;
    const double slope = trend(machine, term, body.axis, lo, hi);
    if (!(std::abs(slope) > kSlopeLimit)) continue;
    findings.warning(
        "W-STRAIGHTNESS-SLOPE", errors[k].mark,
        fmt::format("{} has a linear trend of {:.3g} urad, and {} is given too", to_string(term.name),
                    slope / urad, to_string(squareness->name)),
        "the slope of a straightness is the squareness of the same pair: it would be counted twice",
        fmt::format("remove the trend from {0}; or, if {0} is meant to contain the squareness, remove {1}",
                    to_string(term.name), to_string(squareness->name)));
  }
}

}  // namespace

void check_errors(const Machine& machine, const std::vector<AxisNotes>& axes,
                  const std::vector<ErrorNotes>& errors, Findings& machine_findings,
                  Findings& error_findings) {
  require_errors_seen(machine, axes, machine_findings);
  warn_of_left_out(machine, axes, machine_findings);
  warn_of_slope(machine, errors, error_findings);
}

}  // namespace abbe
