#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>

#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"
#include "common.h"
#include "test_moves.h"
#include "text.h"
#include "verbs.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

/// "+x 12.3 um, -z 4.0 um": the components worth reading, the largest first.
std::string components_text(const Vec3& v, double unit, std::string_view unit_name, int decimals) {
  constexpr double kWorthReading = 0.05;  // of the largest component
  static constexpr char kLetters[] = "xyz";
  std::array<int, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return std::abs(v[a]) > std::abs(v[b]); });
  std::string text;
  for (const int i : order) {
    const double shown = std::abs(v[i]) / unit;
    if (std::abs(v[i]) < kWorthReading * std::abs(v[order[0]]) || shown < 0.5 * std::pow(10.0, -decimals))
      continue;
    text += fmt::format("{}{}{} {:.{}f} {}", text.empty() ? "" : ", ", v[i] < 0 ? '-' : '+', kLetters[i],
                        shown, decimals, unit_name);
  }
  return text.empty() ? fmt::format("0 {}", unit_name) : text;
}

std::string position_text(const Body& axis, double position) {
  return fmt::format("{:.6g}", json_position(axis, position) + 0.0);
}

std::string move_text(const Body& axis, double from, double to) {
  return fmt::format("{} {} -> {} {}", axis.name, position_text(axis, from), position_text(axis, to),
                     axis.type == AxisType::rotary ? "deg" : "mm");
}

std::string axis_line(const Machine& machine, const AxisMove& move) {
  const Body& axis = machine.axis(move.axis);
  const bool rotary = axis.type == AxisType::rotary;
  const char* carried = axis.branch == Branch::tool ? "tool side" : "work side";
  const std::string body = rotary ? "turns about " + components_text(move.body, deg, "deg", 3)
                                  : "moves " + components_text(move.body, mm, "mm", 3);
  const std::string tip = move.tip.norm() < kMaxAxes * 1e-12
                              ? "tip stays"
                              : "tip over work: " + components_text(move.tip, mm, "mm", 3);
  return fmt::format("  {:<28} {} {:<34} {}\n", move_text(axis, move.from, move.to), carried, body, tip);
}

std::string error_line(const Machine& machine, const ErrorTest& test) {
  const ErrorTerm& term = machine.errors[test.error];
  std::string action = "constant: no move shows it";
  if (test.axis) action = move_text(machine.axis(*test.axis), test.from, test.to);
  if (test.sensor) action = fmt::format("{} {:.6g} -> {:.6g}", *test.sensor, test.from, test.to);
  std::string line = fmt::format("  {:<7} {:<28} ", abbe::to_string(term.name), action);
  const std::string tip = components_text(test.tip, um, "um", 3);
  const std::string rotation = components_text(test.rotation, urad, "urad", 3);
  const bool turns = test.rotation.norm() > 1e-9;
  line += turns ? fmt::format("tip {:<36} turns {}", tip, rotation) : fmt::format("tip {}", tip);
  while (line.ends_with(' ')) line.pop_back();
  return line + '\n';
}

void write_text(const Plan& plan, const Environment& environment, Session& session) {
  const Machine& machine = plan.machine();
  Output& out = session.out;
  out.write(fmt::format(
      "machine {}\n\n"
      "1. Directions. Jog each axis up by the amount shown and watch: if the body moves the other way, the\n"
      "   direction in the machine file is wrong, and corrections would be too.\n"
      "   x y z of the bodies are bed axes; the tip is seen from the workpiece.\n\n",
      machine.name));
  for (const AxisMove& move : axis_moves(plan)) out.write(axis_line(machine, move));
  out.write(
      "\n2. Errors, one by one. Measure along the move shown, the other axes at zero (or at the end of the "
      "travel\n"
      "   nearest to it). The line says how the tool departs from the ideal motion, seen from the workpiece, "
      "between\n"
      "   the two ends: +x 3 um means the tool ends 3 um too far in +x of the work; a dial in the spindle "
      "that touches\n"
      "   a straightedge on the table, its plunger pointing to +x, is then pressed in by 3 um. Turns are "
      "right-handed.\n"
      "   If an instrument shows the opposite sign, errors_seen or the sign of that error is wrong.\n\n");
  for (const ErrorTest& test : error_tests(machine, environment, plan.model()))
    out.write(error_line(machine, test));
}

void write_json(const Plan& plan, const Environment& environment, Session& session) {
  const Machine& machine = plan.machine();
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "signcheck", machine);
  json.key("axes").begin_array();
  for (const AxisMove& move : axis_moves(plan)) {
    const Body& axis = machine.axis(move.axis);
    json.begin_object(Layout::one_line);
    json.member("axis", axis.name)
        .member("from", json_position(axis, move.from))
        .member("to", json_position(axis, move.to));
    json.member(axis.type == AxisType::rotary ? "body_rotation_rad" : "body_motion_mm", move.body);
    json.member("tip_motion_mm", move.tip).end();
  }
  json.end();
  json.key("errors").begin_array();
  for (const ErrorTest& test : error_tests(machine, environment, plan.model())) {
    json.begin_object(Layout::one_line);
    json.member("name", abbe::to_string(machine.errors[test.error].name));
    json.key("move").begin_object();
    if (test.axis) {
      const Body& axis = machine.axis(*test.axis);
      json.member("axis", axis.name)
          .member("from", json_position(axis, test.from))
          .member("to", json_position(axis, test.to));
    }
    if (test.sensor) json.member("sensor", *test.sensor).member("from", test.from).member("to", test.to);
    json.end();
    write_positions(json, "other_axes_at", machine, test.at);
    json.member("tip_change_mm", test.tip).member("rotation_change_rad", test.rotation).end();
  }
  json.end().end();
  session.out.write(json.take());
}

}  // namespace

Verb signcheck_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand(
      "signcheck", "test moves and dial readings that show whether the signs are right");
  auto arguments = std::make_shared<CommonArguments>();
  add_common_options(*command, *arguments, session);
  return {command, [arguments, &session] {
            const std::optional<Setting> setting = load_setting(*arguments, session);
            if (!setting) return;
            const std::optional<Plan> plan = plan_or_report(*setting, setting->environment, session);
            if (!plan) return;
            if (arguments->json) {
              write_json(*plan, setting->environment, session);
            } else {
              write_text(*plan, setting->environment, session);
            }
          }};
}

}  // namespace abbe::app
