#include "abbe/machine/control_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "abbe/core/number.h"
#include "abbe/errors/error_name.h"
#include "abbe/machine/machine_sections.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

const std::vector<std::string> kModes{"axis", "tcp"};
const std::vector<std::string> kTiltSolutions{"A+", "A-", "B+", "B-", "C+", "C-"};
const std::vector<std::string> kCodeModes{"axis", "tcp", "tcp-vectors"};
const std::vector<std::string> kTurnings{"linear", "shortest", "sign"};

/// "G43.4" or "M428": a letter and a number with one decimal at most.
std::optional<TcpCode> code_of(std::string_view text) {
  if (text.size() < 2 || (text[0] != 'G' && text[0] != 'M')) return std::nullopt;
  const std::optional<double> number = read_number(text.substr(1));
  if (!number || *number < 0 || *number >= 1000) return std::nullopt;
  const double code = std::nearbyint(*number * 10);
  if (std::abs(code - *number * 10) > 1e-9) return std::nullopt;
  return TcpCode{text[0], static_cast<int>(code), false};
}

void read_codes(const TomlNode& node, ControlModel& control, Findings& findings) {
  if (!expect_kind(node, TomlNode::Kind::table, "control.codes", findings)) return;
  for (const TomlEntry& entry : node.entries) {
    auto code = code_of(entry.key);
    if (!code) {
      findings.error("E-CONTROL", entry.mark, fmt::format("{} is not a G or M code", in_quotes(entry.key)),
                     "a code that is not recognised would leave the control's mode unknown",
                     "write for example: codes = { M428 = \"tcp\", M429 = \"axis\" }");
      continue;
    }
    const auto mode = read_choice(entry.value, kCodeModes, "control.codes." + entry.key, findings);
    if (!mode) continue;
    code->on = *mode != 0;
    code->vectors = *mode == 2;
    control.codes.push_back(*code);
  }
}

void read_vector_rule(const TomlNode& node, VectorRule& rule, Findings& findings) {
  static const std::vector<std::string> kTurns{"nearest"}, kBetween{"axes"};
  if (!expect_kind(node, TomlNode::Kind::table, "control.vectors", findings)) return;
  refuse_other_keys(node, {"turns", "between"}, "control.vectors", findings);
  if (const auto* entry = node.find("turns"))
    rule.nearest = read_choice(entry->value, kTurns, "control.vectors.turns", findings).has_value();
  if (const auto* entry = node.find("between"))
    if (read_choice(entry->value, kBetween, "control.vectors.between", findings))
      rule.between = VectorRule::Between::axes;
}

void read_control_axis(const TomlEntry& entry, const Body& body, const FileUnits& units, ControlAxis& axis,
                       Findings& findings) {
  const std::string what = "control.axis." + entry.key;
  if (!expect_kind(entry.value, TomlNode::Kind::table, what, findings)) return;
  const TomlNode& table = entry.value;
  refuse_other_keys(table, {"origin", "direction", "turning", "resolution"}, "[" + what + "]", findings);
  const bool rotary = body.type == AxisType::rotary;
  if (const auto* value = table.find("origin")) {
    axis.origin = read_vector(value->value, units.length, what + ".origin", findings);
  }
  if (const auto* value = table.find("direction")) {
    axis.direction = read_direction(value->value, what + ".direction", findings);
  }
  if (const auto* value = table.find("turning")) {
    const auto choice = read_choice(value->value, kTurnings, what + ".turning", findings);
    if (choice) axis.turning = static_cast<Turning>(*choice);
    if (choice && !rotary) {
      findings.error("E-CONTROL", value->mark, fmt::format("turning of the linear axis {}", body.name),
                     "only rotary axes turn", "remove the key");
    }
  }
  if (const auto* value = table.find("resolution")) {
    axis.resolution =
        read_quantity(value->value, rotary ? units.angle : units.length, what + ".resolution", findings);
    if (axis.resolution && !(*axis.resolution > 0)) {
      findings.error("E-CONTROL", value->value.mark, "a resolution is above zero",
                     "it is the control's least increment", "write for example resolution = 0.001");
    }
  }
}

void read_control_axes(const TomlNode& node, const std::vector<Body>& bodies, const FileUnits& units,
                       ControlModel& control, Findings& findings) {
  if (!expect_kind(node, TomlNode::Kind::table, "control.axis", findings)) return;
  std::vector<std::string> names;
  for (const Body& body : bodies) {
    if (body.axis >= 0) names.push_back(body.name);
  }
  for (const TomlEntry& entry : node.entries) {
    const auto body = std::find_if(bodies.begin(), bodies.end(),
                                   [&](const Body& b) { return b.axis >= 0 && b.name == entry.key; });
    if (body == bodies.end()) {
      findings.error(
          "E-CONTROL", entry.mark, fmt::format("{} is not a moving axis of this chain", in_quotes(entry.key)),
          "the control's model is of the same chain", suggestion(entry.key, names, "use " + listed(names)));
      continue;
    }
    read_control_axis(entry, *body, units, control.axes[static_cast<std::size_t>(body->axis)], findings);
  }
}

/// "A-".
std::optional<TiltSolution> read_tilt_solution(const TomlNode& node, const std::vector<Body>& bodies,
                                               Findings& findings) {
  const auto choice = read_choice(node, kTiltSolutions, "control.tilt_solution", findings);
  if (!choice) return std::nullopt;
  const std::string& said = kTiltSolutions[*choice];
  const bool turns = std::any_of(bodies.begin(), bodies.end(), [&](const Body& body) {
    return body.type == AxisType::rotary && body.address == said.substr(0, 1);
  });
  if (!turns) {
    findings.error("E-CONTROL", node.mark, fmt::format("no rotary axis has the address {}", said[0]),
                   "the control chooses how its axes stand by the side of zero of one of them",
                   "name a rotary axis of this chain");
    return std::nullopt;
  }
  return TiltSolution{said[0] - 'A', said[1] == '-' ? -1 : 1};
}

}  // namespace

ControlModel read_control(const TomlNode& root, const std::vector<Body>& bodies, const FileUnits& units,
                          Findings& findings) {
  ControlModel control;
  control.axes.resize(static_cast<std::size_t>(
      std::count_if(bodies.begin(), bodies.end(), [](const Body& body) { return body.axis >= 0; })));
  const TomlNode* table = find_table(root, "control", findings);
  if (table == nullptr) return control;
  refuse_other_keys(*table, {"mode", "codes", "vectors", "corrects", "tilt_solution", "axis"}, "[control]",
                    findings);
  if (const auto* entry = table->find("mode")) {
    const auto mode = read_choice(entry->value, kModes, "control.mode", findings);
    control.declared = mode.has_value();
    control.tcp = mode && *mode == 1;
  }
  if (const auto* entry = table->find("codes")) read_codes(entry->value, control, findings);
  if (const auto* entry = table->find("vectors")) read_vector_rule(entry->value, control.vectors, findings);
  if (const auto* entry = table->find("corrects")) {
    if (expect_kind(entry->value, TomlNode::Kind::array, "control.corrects", findings)) {
      for (const TomlNode& item : entry->value.items) {
        if (auto name = read_text(item, "an error of control.corrects", findings))
          control.corrects.push_back(*name);
      }
    }
  }
  if (const auto* entry = table->find("tilt_solution"))
    control.tilt = read_tilt_solution(entry->value, bodies, findings);
  if (const auto* entry = table->find("axis"))
    read_control_axes(entry->value, bodies, units, control, findings);
  return control;
}

void check_corrected_errors(const TomlNode& root, const Machine& machine, Findings& findings) {
  const TomlEntry* table = root.find("control");
  const TomlEntry* list = table != nullptr ? table->value.find("corrects") : nullptr;
  if (list == nullptr) return;
  std::vector<std::string> names;
  for (const ErrorTerm& term : machine.errors) names.push_back(to_string(term.name));
  for (const TomlNode& item : list->value.items) {
    if (item.kind != TomlNode::Kind::text) continue;
    const auto name = read_error_name(item.text);
    const std::string spelled = name ? to_string(*name) : item.text;
    if (std::find(names.begin(), names.end(), spelled) != names.end()) continue;
    findings.warning(
        "W-CONTROL", item.mark, fmt::format("no error {} in this machine", in_quotes(item.text)),
        "an error that the control corrects and this file states otherwise would be corrected twice",
        suggestion(item.text, names, "name the error as in [errors], or remove it"));
  }
}

}  // namespace abbe
