#include "abbe/machine/variable_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace abbe {
namespace {

std::string upper(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return out;
}

/// A capital letter that axes have, then digits: X, B1. T1 is a good name for a sensor.
bool looks_like_an_axis(std::string_view name) {
  constexpr std::string_view kAxisLetters = "XYZABCUVW";
  return !name.empty() && kAxisLetters.find(name.front()) != std::string_view::npos &&
         std::all_of(name.begin() + 1, name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

VariableTable::VariableTable(const std::vector<Body>& bodies, UnitRatio ratio) : ratio_(ratio) {
  for (const Body& body : bodies) {
    names_.push_back(body.name);
    if (body.type == AxisType::fixed) continue;
    variables_.push_back({Variable::Kind::position, body.name, static_cast<int>(axes_.size())});
    axes_.push_back(body);
  }
}

std::optional<int> VariableTable::axis_named(std::string_view name) const {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (axes_[i].name == name) return static_cast<int>(i);
  }
  return std::nullopt;
}

std::optional<Variable> VariableTable::derivative(const TomlNode& name, Findings& findings) const {
  const std::string_view axis = std::string_view(name.text).substr(2);
  if (const auto index = axis_named(axis)) {
    const auto kind = name.text.front() == 'v' ? Variable::Kind::velocity : Variable::Kind::acceleration;
    return Variable{kind, name.text, *index};
  }
  std::vector<std::string> candidates;
  for (const Body& body : axes_) candidates.push_back(name.text.substr(0, 2) + body.name);
  findings.error("E-VARIABLE", name.mark, fmt::format("{} is not a variable", in_quotes(name.text)),
                 "velocity v. and acceleration a. belong to moving axes of the chain",
                 suggestion(name.text, candidates,
                            candidates.empty() ? "the chain has no moving axis"
                                               : "known: " + listed(candidates, "and")));
  return std::nullopt;
}

bool VariableTable::acceptable_sensor(const TomlNode& name, Findings& findings) const {
  const std::string& text = name.text;
  const bool plain = !text.empty() && std::none_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte <= 0x20 || byte == 0x7f || std::string_view(".,;=\"'#").find(c) != std::string_view::npos;
  });
  const bool number_like = !text.empty() && (std::isdigit(static_cast<unsigned char>(text.front())) != 0 ||
                                             text.front() == '-' || text.front() == '+');
  if (!plain || number_like) {
    findings.error("E-VARIABLE", name.mark, fmt::format("{} cannot name a variable", in_quotes(text)),
                   "variables are axis names, v.X, a.X, t and sensors; sensor names have no blanks, dots, "
                   "commas, = or quotes and begin with a letter, as in --set T1=23.4",
                   "choose a name such as T1 or spindle_temperature");
    return false;
  }
  if (std::find(names_.begin(), names_.end(), text) != names_.end()) {
    findings.error("E-VARIABLE", name.mark, fmt::format("{} is a body without motion", in_quotes(text)),
                   "it has no position", "name a moving axis or a sensor");
    return false;
  }
  if (looks_like_an_axis(text)) {
    findings.error(
        "E-VARIABLE", name.mark, fmt::format("axis {} is not in the chain", in_quotes(text)),
        "a sensor must not look like an axis, or a misspelled axis would pass as one",
        suggestion(text, names_, "name an axis of the chain, or give the sensor another name, such as T1"));
    return false;
  }
  for (const std::string& axis : names_) {
    if (upper(text) == axis) {
      findings.warning("W-SENSOR-NAME", name.mark,
                       fmt::format("{} is read as a sensor, not as the axis {}", in_quotes(text), axis),
                       "names of variables tell capital and small letters apart",
                       fmt::format("write \"{}\" for the axis, or give the sensor another name", axis));
    }
  }
  return true;
}

std::optional<int> VariableTable::index_of(const TomlNode& name, Findings& findings) {
  if (name.kind != TomlNode::Kind::text) {
    findings.error("E-TYPE", name.mark, fmt::format("of is {}, expected a text", kind_name(name.kind)), "",
                   "name one variable in quotes: of = \"X\"");
    return std::nullopt;
  }
  const auto known = std::find_if(variables_.begin(), variables_.end(),
                                  [&](const Variable& variable) { return variable.name == name.text; });
  if (known != variables_.end()) return static_cast<int>(known - variables_.begin());
  Variable variable{Variable::Kind::sensor, name.text, -1};
  if (name.text.starts_with("v.") || name.text.starts_with("a.")) {
    const auto found = derivative(name, findings);
    if (!found) return std::nullopt;
    variable = *found;
  } else if (!acceptable_sensor(name, findings)) {
    return std::nullopt;
  }
  variables_.push_back(variable);
  return static_cast<int>(variables_.size()) - 1;
}

double VariableTable::ratio(int variable) const {
  const int axis = at(variable).axis;
  if (axis < 0) return 1;
  return axes_[static_cast<std::size_t>(axis)].type == AxisType::rotary ? ratio_.angle : ratio_.length;
}

const Body* VariableTable::position_of(int variable) const {
  const Variable& found = at(variable);
  return found.kind == Variable::Kind::position ? &axes_[static_cast<std::size_t>(found.axis)] : nullptr;
}

}  // namespace abbe
