#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "abbe/chain/solve_path.h"
#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"
#include "common.h"
#include "inverse_gcode.h"
#include "pose_source.h"
#include "progress.h"
#include "text.h"
#include "verbs.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

constexpr std::size_t kWriteAt = std::size_t{1} << 16;

struct InverseArguments {
  CommonArguments common;
  PoseArguments poses;
  bool ideal = false;
  std::string method = "newton";
  std::vector<std::string> lock;
  GcodeArguments gcode;
};

void write_json_point(JsonWriter& json, const Machine& machine, const ToolPose& pose,
                      const InverseResult& result, bool branch_changed,
                      const std::vector<std::string>& outside, bool pass, bool limits) {
  json.begin_object(Layout::one_line);
  const std::array<double, 6> numbers = {pose.position.x(),  pose.position.y(),  pose.position.z(),
                                         pose.direction.x(), pose.direction.y(), pose.direction.z()};
  json.member("pose", std::span<const double>(numbers));
  write_positions(json, "q", machine, result.q);
  json.key("residual").begin_object();
  json.member("position_mm", result.residual_position)
      .member("direction_rad", result.residual_direction)
      .end();
  json.member("status", abbe::to_string(result.status)).member("branch", result.branch);
  json.member("branch_changed", branch_changed).member("iterations", result.iterations);
  json.member("outside_travel", outside);
  if (limits) json.member("pass", pass);
  json.end();
}

std::string point_text(const Machine& machine, const ToolPose& pose, const InverseResult& result,
                       const std::vector<std::string>& outside) {
  std::string text = fmt::format("tip {:.6f} {:.6f} {:.6f} mm, tool axis {:.9f} {:.9f} {:.9f}\n",
                                 pose.position.x(), pose.position.y(), pose.position.z(), pose.direction.x(),
                                 pose.direction.y(), pose.direction.z());
  text += fmt::format("  commands  {}\n", positions_text(machine, result.q));
  text += fmt::format("  {}, branch {}, remains {:.6f} um and {:.3f} urad", abbe::to_string(result.status),
                      result.branch, result.residual_position / um, result.residual_direction / urad);
  for (std::size_t i = 0; i < outside.size(); ++i)
    text += (i == 0 ? ", outside the travel of " : " ") + outside[i];
  return text + '\n';
}

void inverse_poses(const InverseArguments& arguments, Session& session) {
  const std::optional<Setting> setting = load_controlled_setting(arguments.common, session);
  if (!setting) return;
  const Machine& machine = setting->machine;
  Diagnostics diagnostics;
  PathOptions options;
  options.ideal = arguments.ideal;
  options.correction.method = method_of(arguments.method);
  options.correction.locked = read_lock(machine, arguments.lock, diagnostics);
  const std::array<double, kMaxAxes> start = read_near(machine, arguments.poses.near, diagnostics);
  session.report(diagnostics);
  if (has_errors(diagnostics)) return;
  const std::optional<AxisSet> free = free_axes_or_report(machine, options.correction.locked, session);
  if (!free || !method_fits_or_report(*setting, options.correction.method, *free, session)) return;
  options.free = *free;
  const std::optional<Plan> plan = plan_or_report(*setting, setting->environment, session);
  if (!plan) return;
  std::optional<PoseSource> source = PoseSource::open(arguments.poses, machine.units.length, {}, session);
  if (!source) return;

  const bool as_json = arguments.common.json;
  const Tool tool = tool_of(machine);
  JsonWriter json;
  if (as_json) {
    json.begin_object();
    write_preamble(json, "inverse", machine);
    json.member("model", to_string(setting->model))
        .member("ideal", arguments.ideal)
        .member("method", arguments.method)
        .key("points")
        .begin_array();
  }
  std::uint64_t points = 0, failed = 0, outside_points = 0, passed = 0;
  std::string first_failed, first_outside;
  PathSolver path(options, start);
  ProgressBar bar("inverse", as_json && !source->single());
  while (!interrupted() && session.out.ok() && source->next(session)) {
    const ToolPose& pose = source->pose();
    const InverseResult result = path.pose(*plan, tool, pose.position, pose.direction);
    const std::vector<std::string> outside = outside_travel(machine, result.q);
    const bool solved = result.status != Status::failed;
    const bool pass = solved && setting->limits.pass(result.residual_position, result.residual_direction);
    ++points;
    if (pass) ++passed;
    if (!solved && failed++ == 0) first_failed = source->where();
    if (solved && !outside.empty() && outside_points++ == 0) first_outside = source->where();
    if (as_json) {
      write_json_point(json, machine, pose, result, path.branch_changed(), outside, pass,
                       setting->limits.given());
      if (json.pending() > kWriteAt) session.out.write(json.take());
    } else {
      session.out.write(point_text(machine, pose, result, outside));
      if (setting->limits.given()) session.out.write(pass ? "  pass\n" : "  FAIL\n");
    }
    bar.show(source->bytes_read(), source->bytes_total());
  }

  const auto finding = [](const std::string& where, const char* code, std::string message) {
    Diagnostic diagnostic;
    diagnostic.code = code;
    diagnostic.place.file = where;
    diagnostic.message = std::move(message);
    return diagnostic;
  };
  if (failed > 0) {
    Diagnostic unreachable =
        finding(first_failed, "E-REACH",
                fmt::format("no commands found for {} of {} poses, the first here", failed, points));
    unreachable.why = "the axes of this machine cannot bring the tool there, or not within their travels";
    session.report(unreachable, Exit::outside);
  }
  if (outside_points > 0) {
    session.report(finding(first_outside, "E-TRAVEL",
                           fmt::format("{} of {} poses need positions outside the travels, the first here",
                                       outside_points, points)),
                   Exit::outside);
  }
  const bool complete = !interrupted() && !session.has(Exit::invalid) && !session.has(Exit::internal);
  if (session.strict && setting->limits.given() && passed != points) session.note(Exit::warnings);
  if (!as_json && !source->single()) session.out.write(path_text(machine, path.report()));
  if (as_json) {
    json.end();
    write_path(json, machine, path.report());
    if (setting->limits.given()) json.member("pass", passed == points && complete);
    json.member("complete", complete).end();
    session.out.write(json.take());
  }
}

}  // namespace

Verb inverse_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand("inverse", "commands that bring the tool to a given pose");
  auto arguments = std::make_shared<InverseArguments>();
  add_common_options(*command, arguments->common, session);
  add_pose_options(*command, arguments->poses);
  command->add_flag("--ideal", arguments->ideal, "of the ideal machine: errors are ignored");
  command->add_option("--lock", arguments->lock, "axes that stay where --near says: Z1,B1")
      ->type_name("AXIS,..")
      ->allow_extra_args(false);
  add_method_option(*command, arguments->method);
  add_gcode_options(*command, arguments->gcode);
  return {command, [arguments, &session] {
            if (arguments->gcode.emit.empty()) return inverse_poses(*arguments, session);
            write_gcode(arguments->common, arguments->poses, arguments->ideal, arguments->gcode, session);
          }};
}

}  // namespace abbe::app
