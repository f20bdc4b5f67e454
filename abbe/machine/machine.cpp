#include "abbe/machine/machine.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace abbe {

std::vector<Factor> line_order() {
  return {{FactorKind::along, false},  {FactorKind::across, false},  {FactorKind::motion, false},
          {FactorKind::across, true},  {FactorKind::thermal, false}, {FactorKind::component, false},
          {FactorKind::dynamic, false}};
}

std::vector<Factor> frame_order() {
  return {{FactorKind::location, false},
          {FactorKind::motion, false},
          {FactorKind::thermal, false},
          {FactorKind::component, false},
          {FactorKind::dynamic, false}};
}

std::vector<Factor> after_order() {
  return {{FactorKind::motion, false},
          {FactorKind::location, false},
          {FactorKind::thermal, false},
          {FactorKind::component, false},
          {FactorKind::dynamic, false}};
}

bool carries(const Body& body, const ErrorName& name) {
  const auto has = [&](FactorKind kind) {
    return std::any_of(body.order.begin(), body.order.end(),
                       [&](const Factor& factor) { return factor.kind == kind; });
  };
  switch (name.error_class) {
    case ErrorClass::component:
      return has(FactorKind::component);
    case ErrorClass::thermal:
      return has(FactorKind::thermal);
    case ErrorClass::dynamic:
      return has(FactorKind::dynamic);
    case ErrorClass::location:
      break;
  }
  if (has(FactorKind::location)) return true;
  // across = the rotation perpendicular to u of a linear axis, both parts perpendicular to u of a
  // rotary one; along = the rest. A unit error parallel to u has no part across.
  constexpr double kParallel = 1e-12;
  const double along_u = std::abs(body.direction[name.direction % 3]);
  const bool splits = name.is_rotation() || body.type != AxisType::linear;
  const bool has_across_part = splits && along_u < 1 - kParallel;
  const bool has_along_part = !splits || along_u > kParallel;
  return (has_across_part && has(FactorKind::across)) || (has_along_part && has(FactorKind::along));
}

int Machine::find_axis(std::string_view axis_name) const {
  for (int i = 0; i < axis_count(); ++i) {
    if (axis(i).name == axis_name) return i;
  }
  return -1;
}

double Machine::axis_unit(int i) const {
  return axis(i).type == AxisType::rotary ? units.angle : units.length;
}

bool Machine::has_angular_errors() const {
  const auto is_zero = [](const ErrorTerm& term) {
    return term.function.is_constant() && term.function.value<double>(nullptr, nullptr, nullptr) == 0;
  };
  // A squareness in the `line` order turns the line a linear axis runs along, not what it carries.
  const auto turns_the_line_only = [&](const ErrorTerm& term) {
    if (term.name.error_class != ErrorClass::location || term.body < 0) return false;
    const Body& body = bodies[static_cast<std::size_t>(term.body)];
    return body.type == AxisType::linear && body.order == line_order() &&
           std::abs(body.direction[term.name.direction - 3]) < 1e-12;
  };
  return std::any_of(errors.begin(), errors.end(), [&](const ErrorTerm& term) {
    return term.name.is_rotation() && !is_zero(term) && !turns_the_line_only(term);
  });
}

std::vector<BodyNumber> body_numbers(const Machine& machine) {
  std::vector<BodyNumber> numbers{{0, "b", 0}};
  const auto add_branch = [&](const auto& names) {
    int lower = 0;
    for (const std::string& name : names) {
      const int id = static_cast<int>(numbers.size());
      numbers.push_back({id, name, lower});
      lower = id;
    }
  };
  std::vector<std::string> tool_branch;
  std::vector<std::string> workpiece_branch;
  for (const Body& body : machine.bodies) {
    (body.branch == Branch::tool ? tool_branch : workpiece_branch).push_back(body.name);
  }
  std::reverse(workpiece_branch.begin(), workpiece_branch.end());  // the chain runs from the workpiece
  tool_branch.emplace_back("t");
  workpiece_branch.emplace_back("w");
  add_branch(tool_branch);
  add_branch(workpiece_branch);
  return numbers;
}

std::vector<std::vector<int>> lower_body_array(const std::vector<BodyNumber>& bodies) {
  int count = 0;
  for (const BodyNumber& body : bodies) count = std::max(count, body.id);
  std::vector<int> lower(static_cast<std::size_t>(count) + 1, 0);
  for (const BodyNumber& body : bodies) {
    if (body.id > 0 && body.lower > 0 && body.lower <= count) {
      lower[static_cast<std::size_t>(body.id)] = body.lower;
    }
  }
  std::vector<int> row;  // L^0(i) = i
  for (int i = 1; i <= count; ++i) row.push_back(i);
  std::vector<std::vector<int>> rows;
  // A tree of n bodies reaches the bed after n steps; a cycle never does and must not run on.
  for (int n = 0; n <= count && !row.empty(); ++n) {
    rows.push_back(row);
    if (std::all_of(row.begin(), row.end(), [](int id) { return id == 0; })) break;
    // L^n(i) = L(L^(n-1)(i)),  L(0) = 0
    for (int& id : row) id = lower[static_cast<std::size_t>(id)];
  }
  return rows;
}

std::vector<std::string> error_inventory(const Machine& machine) {
  std::vector<std::string> names;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& body = machine.axis(i);
    for (int direction = 0; direction < 6; ++direction) {
      names.push_back(to_string(ErrorName{ErrorClass::component, direction, body.name}));
    }
    for (int direction = 0; direction < 6; ++direction) {
      const ErrorName name{ErrorClass::location, direction, body.name};
      if (carries(body, name)) names.push_back(to_string(name));
    }
  }
  return names;
}

Machine as_controlled(const Machine& machine) {
  Machine out = machine;
  std::vector<ErrorName> corrected;
  for (const std::string& text : machine.control.corrects) {
    if (const auto name = read_error_name(text)) corrected.push_back(*name);
  }
  std::erase_if(out.errors, [&](const ErrorTerm& term) {
    return std::find(corrected.begin(), corrected.end(), term.name) != corrected.end();
  });
  return out;
}

Machine as_believed(const Machine& machine) {
  Machine out = machine;
  out.errors.clear();
  for (std::size_t i = 0; i < machine.control.axes.size() && i < out.axes.size(); ++i) {
    Body& body = out.bodies[static_cast<std::size_t>(out.axes[i])];
    const ControlAxis& axis = machine.control.axes[i];
    if (axis.origin) body.origin = *axis.origin;
    if (axis.direction) body.direction = *axis.direction;
  }
  return out;
}

std::vector<std::string> errors_of_one_test(const Machine& machine) {
  std::vector<std::string> names;
  for (const ErrorTerm& term : machine.errors)
    if (term.of_one_test) names.push_back(to_string(term.name));
  return names;
}

std::optional<Diagnostic> refusal_of_one_test(const Machine& machine) {
  const std::vector<std::string> names = errors_of_one_test(machine);
  if (names.empty()) return std::nullopt;
  Diagnostic d;
  d.code = "E-SCOPE";
  d.place.file = machine.files.empty() ? "machine" : machine.files.back();
  for (const std::string& name : names) d.message += name + " ";
  d.message += names.size() == 1 ? "is" : "are";
  d.message += " true of one test only (scope = \"test\")";
  d.why =
      "such a part depends on the feed and the time of that test; on another path it would be an error of "
      "its own";
  d.fix = "remove it from the errors file, or identify it as a function of v. and a.";
  return d;
}

}  // namespace abbe
