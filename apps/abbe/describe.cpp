#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "abbe/chain/effect.h"
#include "abbe/core/units.h"
#include "abbe/machine/machine.h"
#include "abbe/report/json_writer.h"
#include "common.h"
#include "text.h"
#include "verbs.h"

namespace abbe::app {
namespace {

std::string_view type_name(AxisType type) {
  switch (type) {
    case AxisType::rotary:
      return "rotary";
    case AxisType::fixed:
      return "fixed";
    case AxisType::linear:
      break;
  }
  return "linear";
}

std::string_view branch_name(Branch branch) { return branch == Branch::tool ? "tool" : "workpiece"; }

/// Names of the errors given for a body, in file order.
std::vector<std::string> errors_of(const Machine& machine, int body) {
  std::vector<std::string> names;
  for (const ErrorTerm& term : machine.errors) {
    if (term.body == body) names.push_back(abbe::to_string(term.name));
  }
  return names;
}

bool is_body_error(ErrorClass error_class) { return error_class != ErrorClass::location; }

/// What a positive value means, in the words of someone at the machine.
std::string meaning_of_errors(const Machine& machine, std::size_t body) {
  const Body& axis = machine.bodies[body];
  const bool carries = std::any_of(machine.errors.begin(), machine.errors.end(), [&](const ErrorTerm& term) {
    return term.body == static_cast<int>(body) && is_body_error(term.name.error_class);
  });
  if (!carries) return "no component, thermal or dynamic error is given";
  if (axis.branch == Branch::tool) {
    return fmt::format(
        "values are errors of the {} body, which carries the tool: a positive EX{} puts the tool "
        "too far in +x of the workpiece",
        axis.name, axis.name);
  }
  if (axis.errors_seen_at_tool) {
    return fmt::format(
        "values are errors of the tool as seen from the workpiece on {}: a positive EX{} means that "
        "the tool is too far in +x of the workpiece",
        axis.name, axis.name);
  }
  return fmt::format(
      "values are errors of the {} body, which carries the workpiece: a positive EX{} puts the "
      "workpiece too far in +x, so the tool is too far in -x of the workpiece",
      axis.name, axis.name);
}

void write_json(const Setting& setting, Session& session) {
  const Machine& machine = setting.machine;
  using Layout = JsonWriter::Layout;
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "describe", machine);
  const std::vector<BodyNumber> bodies = body_numbers(machine);
  json.key("bodies").begin_array();
  for (const BodyNumber& body : bodies) {
    json.begin_object(Layout::one_line);
    json.member("id", body.id).member("name", body.name).member("lower", body.lower).end();
  }
  json.end();
  json.key("lower_body_array").begin_array();
  for (const std::vector<int>& row : lower_body_array(bodies)) {
    json.begin_array(Layout::one_line);
    for (const int id : row) json.value(id);
    json.end();
  }
  json.end();
  json.key("axes").begin_array();
  for (std::size_t i = 0; i < machine.bodies.size(); ++i) {
    const Body& axis = machine.bodies[i];
    json.begin_object(Layout::one_line);
    json.member("name", axis.name)
        .member("type", type_name(axis.type))
        .member("branch", branch_name(axis.branch));
    if (axis.type == AxisType::fixed) {
      json.key("direction").null();
    } else {
      json.member("direction", axis.direction);
    }
    json.member("origin_mm", axis.origin);
    json.key("range");
    if (axis.range) {
      const std::array<double, 2> range = {json_position(axis, (*axis.range)[0]),
                                           json_position(axis, (*axis.range)[1])};
      json.value(std::span<const double>(range));
    } else {
      json.null();
    }
    json.member("correctable", axis.correctable && axis.type != AxisType::fixed);
    json.member("errors", errors_of(machine, static_cast<int>(i)));
    if (axis.type != AxisType::fixed) {
      const bool tool = axis.branch == Branch::tool || axis.errors_seen_at_tool;
      json.member("errors_seen", tool ? "tool" : "body").member("errors_mean", meaning_of_errors(machine, i));
    }
    json.end();
  }
  json.end();
  json.key("tool").begin_object(Layout::one_line);
  const Vec3 tip = machine.tool.origin - machine.tool.length * machine.tool.axis;
  json.member("tip_mm", tip).member("axis", machine.tool.axis).member("length_mm", machine.tool.length).end();
  json.member("workpiece_origin_mm", machine.workpiece_origin);
  std::vector<std::string> names;
  for (const ErrorTerm& term : machine.errors) names.push_back(abbe::to_string(term.name));
  json.key("errors").begin_object();
  json.member("count", static_cast<std::uint64_t>(names.size())).member("names", names).end();
  json.member("inventory", error_inventory(machine));
  json.member("errors_without_effect", errors_without_effect(machine));
  std::vector<std::string> sensors;
  for (const Variable& variable : machine.variables) {
    if (variable.kind == Variable::Kind::sensor) sensors.push_back(variable.name);
  }
  json.member("sensors", sensors);
  write_findings(json, "warnings", setting.findings);
  json.end();
  session.out.write(json.take());
}

std::string joined(const std::vector<std::string>& names, std::string_view separator = " ") {
  std::string text;
  for (const std::string& name : names) {
    if (!text.empty()) text += separator;
    text += name;
  }
  return text.empty() ? "-" : text;
}

/// Long lists of names, wrapped under their own start.
std::string wrapped(const std::vector<std::string>& names, std::size_t indent) {
  constexpr std::size_t kWidth = 100;
  std::string text;
  std::size_t column = indent;
  for (const std::string& name : names) {
    if (column > indent && column + 1 + name.size() > kWidth) {
      text += '\n';
      text.append(indent, ' ');
      column = indent;
    } else if (column > indent) {
      text += ' ';
      ++column;
    }
    text += name;
    column += name.size();
  }
  return text.empty() ? "-" : text;
}

std::string vector_text(const Vec3& v) { return fmt::format("{:.6g} {:.6g} {:.6g}", v.x(), v.y(), v.z()); }

std::string calibration_text(const Calibration& calibration) {
  std::vector<std::string> parts;
  if (!calibration.date.empty()) parts.push_back(calibration.date);
  if (!calibration.machine_id.empty()) parts.push_back("machine " + calibration.machine_id);
  if (calibration.temperature) parts.push_back(fmt::format("{:.1f} degC", *calibration.temperature));
  if (!calibration.valid_to.empty()) parts.push_back("valid to " + calibration.valid_to);
  if (!calibration.control_compensation.empty())
    parts.push_back("control: " + calibration.control_compensation);
  return joined(parts, ", ");
}

void write_text(const Machine& machine, Session& session) {
  Output& out = session.out;
  out.write(fmt::format(
      "machine      {}\nchain        {}\nfiles        {}\nsha256       {}\ncalibration  {}\n", machine.name,
      machine.chain, joined(machine.files), machine.sha256, calibration_text(machine.calibration)));

  const std::vector<BodyNumber> bodies = body_numbers(machine);
  out.write("\nbodies\n  id  name  lower\n");
  for (const BodyNumber& body : bodies) {
    out.write(fmt::format("  {:>2}  {:<4}  {:>5}\n", body.id, body.name,
                          body.id == 0 ? std::string("-") : std::to_string(body.lower)));
  }
  out.write("\nlower-body array\n  body ");
  for (std::size_t i = 1; i < bodies.size(); ++i) out.write(fmt::format("{:>4}", bodies[i].name));
  out.write("\n");
  const std::vector<std::vector<int>> array = lower_body_array(bodies);
  for (std::size_t n = 0; n < array.size(); ++n) {
    out.write(fmt::format("  L^{:<3}", n));
    for (const int id : array[n]) out.write(fmt::format("{:>4}", id));
    out.write("\n");
  }

  out.write("\naxes\n");
  out.write(fmt::format("  {:<5} {:<7} {:<10} {:<24} {:<24} {}\n", "name", "type", "carries",
                        "body moves along, +", "origin (mm)", "travel"));
  for (const Body& axis : machine.bodies) {
    std::string travel = "not stated";
    if (axis.range) {
      travel =
          fmt::format("{:.6g} .. {:.6g} {}", json_position(axis, (*axis.range)[0]),
                      json_position(axis, (*axis.range)[1]), axis.type == AxisType::rotary ? "deg" : "mm");
    }
    if (axis.type == AxisType::fixed) travel = "-";
    const std::string direction =
        axis.type == AxisType::fixed
            ? "-"
            : (axis.type == AxisType::rotary ? "about " : "") + vector_text(axis.direction);
    out.write(fmt::format("  {:<5} {:<7} {:<10} {:<24} {:<24} {}{}\n", axis.name, type_name(axis.type),
                          branch_name(axis.branch), direction, vector_text(axis.origin), travel,
                          axis.correctable || axis.type == AxisType::fixed ? "" : ", never corrected"));
  }
  const Vec3 tip = machine.tool.origin - machine.tool.length * machine.tool.axis;
  out.write(
      fmt::format("\ntool         tip {} mm, axis {} (from the tip to the spindle), gauge length {:.6g} mm\n",
                  vector_text(tip), vector_text(machine.tool.axis), machine.tool.length));
  out.write(fmt::format("workpiece    origin {} mm\n", vector_text(machine.workpiece_origin)));

  out.write(fmt::format("\nerrors       {} given\n", machine.errors.size()));
  for (std::size_t i = 0; i < machine.bodies.size(); ++i) {
    out.write(fmt::format("  {:<10} {}\n", machine.bodies[i].name,
                          wrapped(errors_of(machine, static_cast<int>(i)), 13)));
  }
  for (const auto& [body, name] : {std::pair{kToolBody, "t (tool)"}, std::pair{kWorkpieceBody, "w (work)"}}) {
    const std::vector<std::string> names = errors_of(machine, body);
    if (!names.empty()) out.write(fmt::format("  {:<10} {}\n", name, wrapped(names, 13)));
  }
  std::vector<std::string> absent;
  for (const std::string& name : error_inventory(machine)) {
    const bool given = std::any_of(machine.errors.begin(), machine.errors.end(),
                                   [&](const ErrorTerm& term) { return abbe::to_string(term.name) == name; });
    if (!given) absent.push_back(name);
  }
  out.write(fmt::format("  {:<10} {}\n", "not given", wrapped(absent, 13)));
  const std::vector<std::string> idle = errors_without_effect(machine);
  if (!idle.empty()) out.write(fmt::format("  {:<10} {}\n", "no effect", wrapped(idle, 13)));
  out.write("\nwhat the signs mean\n");
  for (std::size_t i = 0; i < machine.bodies.size(); ++i) {
    if (machine.bodies[i].type == AxisType::fixed) continue;
    out.write(fmt::format("  {:<5} {}\n", machine.bodies[i].name, meaning_of_errors(machine, i)));
  }
}

}  // namespace

Verb describe_verb(Command& program, Session& session) {
  Command* command =
      program.add_subcommand("describe", "what a machine file says: bodies, axes, errors, signs");
  auto arguments = std::make_shared<CommonArguments>();
  add_common_options(*command, *arguments, session);
  return {command, [arguments, &session] {
            const std::optional<Setting> setting = load_setting(*arguments, session);
            if (!setting) return;
            if (arguments->json) {
              write_json(*setting, session);
            } else {
              write_text(setting->machine, session);
            }
          }};
}

}  // namespace abbe::app
