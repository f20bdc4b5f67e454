#include "abbe/identify/model_term.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

/// 0..2 of the coordinate along which a linear axis moves; -1 if it is askew.
int direction_of(const Body& axis) {
  Eigen::Index along = 0;
  return axis.direction.cwiseAbs().maxCoeff(&along) > 1 - 1e-9 ? static_cast<int>(along) : -1;
}

class Chooser {
 public:
  Chooser(const Machine& machine, const std::vector<Travel>& travel, const TermChoice& choice)
      : machine_(machine), travel_(travel), choice_(choice) {}

  void add_squareness(const std::vector<int>& moving) {
    if (!choice_.squareness) return;
    for (std::size_t i = 0; i < moving.size(); ++i) {
      for (std::size_t k = i + 1; k < moving.size(); ++k) {
        const int a = direction_of(machine_.axis(moving[i])), b = direction_of(machine_.axis(moving[k]));
        if (a < 0 || b < 0 || a == b) continue;
        // Rotation of the line of the second axis about the normal of the plane.
        add(ModelTerm::Form::constant, ErrorClass::location, 3 + (3 - a - b), moving[k], 0);
      }
    }
  }

  void add_axis(int axis) {
    using Form = ModelTerm::Form;
    const int along = direction_of(machine_.axis(axis));
    if (along < 0) return;
    const bool splines = choice_.splines > 0;
    const int powers = splines ? std::min(choice_.positioning, 1) : choice_.positioning;
    for (int n = 1; n <= powers; ++n) add(Form::power, ErrorClass::component, along, axis, n);
    if (splines && choice_.positioning > 0) add_splines(along, axis);
    for (int d = 0; d < 3; ++d) {
      if (d == along) continue;
      if (splines && choice_.straightness > 1) add_splines(d, axis);
      for (int n = 2; !splines && n <= choice_.straightness; ++n)
        add(Form::power, ErrorClass::component, d, axis, n);
    }
    for (int d = 3; d < 6; ++d)
      for (int n = 1; n <= choice_.rotation; ++n) add(Form::power, ErrorClass::component, d, axis, n);
    for (int d = 0; d < 3; ++d)
      if (d == along ? choice_.lost_motion : choice_.lateral_play)
        add(Form::lost_motion, ErrorClass::component, d, axis, 0);
    for (int d = 0; d < 3; ++d) {
      if (d != along && !choice_.cross) continue;
      if (choice_.velocity) add(Form::velocity, ErrorClass::dynamic, d, axis, 1);
      if (choice_.acceleration) add(Form::acceleration, ErrorClass::dynamic, d, axis, 1);
    }
  }

  std::vector<ModelTerm> take() { return std::move(terms_); }

 private:
  /// Two of the nodes less: a constant and a line are found elsewhere.
  void add_splines(int direction, int axis) {
    const Travel& travel = travel_[static_cast<std::size_t>(axis)];
    for (int node = 1; node + 1 < choice_.splines && travel[0] < travel[1]; ++node) {
      if (add(ModelTerm::Form::spline, ErrorClass::component, direction, axis, node))
        terms_.back().spline = std::make_shared<const NodalSpline>(travel, choice_.splines, node);
    }
  }

  bool add(ModelTerm::Form form, ErrorClass error_class, int direction, int axis, int power) {
    const Body& body = machine_.axis(axis);
    ModelTerm term{form, {error_class, direction, body.name}, axis, power, {}, nullptr};
    if (form == ModelTerm::Form::power && direction < 3 && power > 1 && direction != direction_of(body))
      term.line = trend_line(power, travel_[static_cast<std::size_t>(axis)]);
    const bool acts = carries(body, term.name);
    if (acts) terms_.push_back(term);
    return acts;
  }

  const Machine& machine_;
  const std::vector<Travel>& travel_;
  const TermChoice& choice_;
  std::vector<ModelTerm> terms_;
};

}  // namespace

double basis(const ModelTerm& term, const AxisState& state) {
  const auto i = static_cast<std::size_t>(term.axis);
  switch (term.form) {
    case ModelTerm::Form::constant:
      return 1;
    case ModelTerm::Form::power:
      return std::pow(state.q[i], term.power) - (term.line[0] + term.line[1] * state.q[i]);
    case ModelTerm::Form::spline:
      return (*term.spline)(state.q[i]);
    case ModelTerm::Form::lost_motion:
      return -0.5 * state.approach[i];
    case ModelTerm::Form::velocity:
      return state.v[i];
    case ModelTerm::Form::acceleration:
      return state.a[i];
  }
  return 0;
}

std::string to_string(const ModelTerm& term, const Machine& machine) {
  const std::string name = to_string(term.name), axis = machine.axis(term.axis).name;
  switch (term.form) {
    case ModelTerm::Form::constant:
      return name;
    case ModelTerm::Form::power:
      return term.power == 1 ? fmt::format("{} {}", name, axis)
                             : fmt::format("{} {}^{}", name, axis, term.power);
    case ModelTerm::Form::spline:
      return fmt::format("{} {} node {}", name, axis, term.power + 1);
    case ModelTerm::Form::lost_motion:
      return fmt::format("{} lost motion", name);
    case ModelTerm::Form::velocity:
      return fmt::format("{} v.{}", name, axis);
    case ModelTerm::Form::acceleration:
      return fmt::format("{} a.{}", name, axis);
  }
  return name;
}

std::vector<ModelTerm> choose_terms(const Machine& machine, const std::vector<int>& moving,
                                    const std::vector<Travel>& travel, const TermChoice& choice) {
  Chooser chooser(machine, travel, choice);
  chooser.add_squareness(moving);
  for (const int axis : moving) chooser.add_axis(axis);
  return chooser.take();
}

std::array<double, 2> trend_line(int power, const Travel& travel) {
  // q = m + L x, x in [-1, 1]: the trend is 3 mean(q^n x) per x
  const double m = (travel[0] + travel[1]) / 2, L = (travel[1] - travel[0]) / 2;
  if (!(L > 0)) return {0, 0};
  double moment = 0, choose = 1;
  for (int k = 0; k <= power; ++k) {
    // The mean of x^(k + 1) is 1 / (k + 2) for odd k, else 0.
    if (k % 2 == 1) moment += choose * std::pow(m, power - k) * std::pow(L, k) / (k + 2);
    choose = choose * (power - k) / (k + 1);
  }
  const double slope = 3 * moment / L;
  return {std::pow(m, power) - slope * m, slope};
}

}  // namespace abbe
