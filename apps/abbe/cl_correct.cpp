#include <fmt/core.h>

#include <array>
#include <memory>
#include <string>
#include <variant>

#include "abbe/chain/relative_deviation.h"
#include "abbe/chain/solve_path.h"
#include "abbe/core/file.h"
#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"
#include "common.h"
#include "pose_deviations.h"
#include "pose_source.h"
#include "progress.h"
#include "text.h"
#include "verbs.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

constexpr std::size_t kWriteAt = std::size_t{1} << 16;

struct ClCorrectArguments {
  CommonArguments common;
  PoseArguments poses;
  std::string deviations, sources, output, method = "newton";
  std::vector<std::string> lock;
};

/// What of each side counts: an error must not enter by the machine file and by the measurement.
struct Sources {
  bool gear = true, tool = true;  ///< the measured deviations of this side are used
  Machine machine;                ///< with the errors that are used
};

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kMost; ++i) text += (i == 0 ? "" : " ") + names[i];
  return names.size() > kMost ? fmt::format("{} and {} more", text, names.size() - kMost) : text;
}

/// nullopt after E-TWICE.
std::optional<Sources> choose_sources(const Machine& machine, const DeviationColumns& deviations,
                                      const std::string& choice, Session& session) {
  Sources sources;
  sources.machine = machine;
  bool known_twice = false;
  const auto side = [&](Branch branch, const char* what, bool measured, bool& used) {
    const std::vector<std::string> names = errors_of(machine, branch);
    used = measured;
    if (!measured || names.empty() || choice == "both") return;
    if (choice == "model") {
      used = false;
    } else if (choice == "deviations") {
      sources.machine = without_errors_of(sources.machine, branch);
    } else {
      Diagnostic twice;
      twice.code = "E-TWICE";
      twice.place.file = machine.files.empty() ? "machine" : machine.files.front();
      twice.message = fmt::format(
          "the machine file has errors on the side of the {} ({}), and deviations of the {} are given", what,
          listed(names), what);
      twice.why =
          "a measured deviation contains what the machine's errors do: corrected twice it is an error again";
      twice.fix =
          "--sources deviations (without those errors), model (without those deviations), or both if the "
          "deviations were measured with the machine already corrected";
      session.report(twice);
      known_twice = true;
    }
  };
  side(Branch::workpiece, "gear", deviations.has_gear(), sources.gear);
  side(Branch::tool, "tool", deviations.has_tool(), sources.tool);
  if (known_twice) return std::nullopt;
  return sources;
}

/// One pose: the wanted one, what is known of it, the one to ask for.
struct CorrectedCl {
  TipAndAxis wanted, asked;
  RelativeDeviation fixed, moving;
};

CorrectedCl correct_cl(const Pose& ideal, const TipAndAxis& wanted, DeviationColumns::Values values,
                       const Sources& sources) {
  for (PoseDeviations* of : {&values.fixed, &values.moving}) {
    if (!sources.gear) of->gear = Twist{};
    if (!sources.tool) of->tool = Twist{};
  }
  CorrectedCl cl;
  cl.wanted = wanted;
  cl.fixed = relative_deviation(ideal, values.fixed);
  cl.moving = relative_deviation(ideal, values.moving);
  cl.asked = corrected_pose(wanted, {cl.fixed, cl.moving});
  return cl;
}

void write_pose(JsonWriter& json, std::string_view name, const TipAndAxis& pose) {
  const std::array<double, 6> numbers = {pose.position.x(),  pose.position.y(),  pose.position.z(),
                                         pose.tool_axis.x(), pose.tool_axis.y(), pose.tool_axis.z()};
  json.member(name, std::span<const double>(numbers));
}

void write_relative(JsonWriter& json, std::string_view name, const RelativeDeviation& relative) {
  const auto vector = [&](std::string_view member, const Vec3& v) {
    json.member(member, std::span<const double>(v.data(), 3));
  };
  json.key(name).begin_object();
  vector("position_mm", relative.position);
  vector("rotation_rad", relative.rotation);
  json.end();
}

void write_json_point(JsonWriter& json, const Machine& machine, const CorrectedCl& cl,
                      const InverseResult& result, const std::vector<std::string>& outside,
                      std::optional<bool> pass) {
  json.begin_object(Layout::one_line);
  write_pose(json, "pose", cl.wanted);
  write_relative(json, "static", cl.fixed);
  write_relative(json, "motion", cl.moving);
  write_pose(json, "corrected_pose", cl.asked);
  write_positions(json, "q", machine, result.q);
  json.key("residual").begin_object();
  json.member("position_mm", result.residual_position)
      .member("direction_rad", result.residual_direction)
      .end();
  json.member("status", abbe::to_string(result.status)).member("outside_travel", outside);
  if (pass) json.member("pass", *pass);
  json.end();
}

std::string point_text(const Machine& machine, const CorrectedCl& cl, const InverseResult& result) {
  const auto pose = [](const TipAndAxis& p) {
    return fmt::format("tip {:.6f} {:.6f} {:.6f} mm, tool axis {:.9f} {:.9f} {:.9f}", p.position.x(),
                       p.position.y(), p.position.z(), p.tool_axis.x(), p.tool_axis.y(), p.tool_axis.z());
  };
  const auto relative = [](const char* name, const RelativeDeviation& r) {
    return fmt::format("  {:<9} {:+.3f} {:+.3f} {:+.3f} um, {:+.3f} {:+.3f} {:+.3f} urad\n", name,
                       r.position.x() / um, r.position.y() / um, r.position.z() / um, r.rotation.x() / urad,
                       r.rotation.y() / urad, r.rotation.z() / urad);
  };
  return fmt::format("{}\n{}{}  ask for   {}\n  commands  {}\n  {}\n", pose(cl.wanted),
                     relative("static", cl.fixed), relative("motion", cl.moving), pose(cl.asked),
                     positions_text(machine, result.q), abbe::to_string(result.status));
}

std::string csv_row(const TipAndAxis& pose) {
  return fmt::format("{},{},{},{},{},{}\n", pose.position.x(), pose.position.y(), pose.position.z(),
                     pose.tool_axis.x(), pose.tool_axis.y(), pose.tool_axis.z());
}

void report_point(const char* code, const std::string& where, const char* message, const char* why,
                  Session& session) {
  Diagnostic diagnostic;
  diagnostic.code = code;
  diagnostic.place.file = where;
  diagnostic.message = message;
  diagnostic.why = why;
  session.report(diagnostic, Exit::outside);
}

/// The commands of both: the wanted pose on the ideal machine says how the tool is turned, the asked one on
/// the real machine is the answer.
class Solver {
 public:
  Solver(const Plan& plan, const Tool& tool, PathOptions options, const std::array<double, kMaxAxes>& start)
      : plan_(plan), tool_(tool), ideal_(ideal_options(options), start), actual_(options, start) {}

  [[nodiscard]] std::optional<Pose> ideal(const TipAndAxis& wanted) {
    const InverseResult result = ideal_.pose(plan_, tool_, wanted.position, wanted.tool_axis);
    if (result.status != Status::ok) return std::nullopt;
    Query query;
    query.tool = tool_;
    query.q = result.q;
    return nominal_pose(plan_, query);
  }
  [[nodiscard]] InverseResult actual(const TipAndAxis& asked) {
    return actual_.pose(plan_, tool_, asked.position, asked.tool_axis);
  }
  [[nodiscard]] const PathReport& report() const { return actual_.report(); }

 private:
  [[nodiscard]] static PathOptions ideal_options(PathOptions options) {
    options.ideal = true;
    return options;
  }
  const Plan& plan_;
  Tool tool_;
  PathSolver ideal_, actual_;
};

void cl_correct(const ClCorrectArguments& arguments, Session& session) {
  std::optional<Setting> setting = load_controlled_setting(arguments.common, session);
  if (!setting) return;
  Diagnostics diagnostics;
  PathOptions options;
  options.correction.method = method_of(arguments.method);
  options.correction.locked = read_lock(setting->machine, arguments.lock, diagnostics);
  const std::array<double, kMaxAxes> start = read_near(setting->machine, arguments.poses.near, diagnostics);
  session.report(diagnostics);
  if (has_errors(diagnostics)) return;
  const std::optional<AxisSet> free =
      free_axes_or_report(setting->machine, options.correction.locked, session);
  if (!free) return;
  options.free = *free;

  DeviationColumns deviations;
  std::optional<PoseSource> source =
      PoseSource::open(arguments.poses, setting->machine.units.length, deviations.names(), session);
  if (!source || !deviations.open(arguments.deviations, *source, session)) return;
  std::optional<Sources> sources = choose_sources(setting->machine, deviations, arguments.sources, session);
  if (!sources) return;
  setting->machine = sources->machine;
  const Machine& machine = setting->machine;
  if (!method_fits_or_report(*setting, options.correction.method, *free, session)) return;
  const std::optional<Plan> plan = plan_or_report(*setting, setting->environment, session);
  if (!plan) return;

  for (const std::string* input :
       {&arguments.common.machine, &arguments.poses.poses, &arguments.deviations}) {
    if (arguments.output.empty() || !same_file(arguments.output, *input)) continue;
    session.report(
        option_error("--output", fmt::format("'{}' is an input", arguments.output), "name another file"));
    return;
  }
  std::optional<SpoolFile> output;
  if (!arguments.output.empty()) {
    FileResult<SpoolFile> created = SpoolFile::create(arguments.output);
    if (const auto* error = std::get_if<FileError>(&created)) {
      session.report(*error, arguments.output);
      return;
    }
    output.emplace(std::move(std::get<SpoolFile>(created)));
    static_cast<void>(output->write("x_mm,y_mm,z_mm,i,j,k\n"));
  }

  const bool as_json = arguments.common.json;
  JsonWriter json;
  if (as_json) {
    json.begin_object();
    write_preamble(json, "cl-correct", machine);
    json.member("model", to_string(setting->model)).member("method", arguments.method);
    json.key("sources").begin_object(Layout::one_line);
    json.member("gear_deviations", sources->gear && deviations.has_gear())
        .member("tool_deviations", sources->tool && deviations.has_tool())
        .member("machine_errors", static_cast<std::uint64_t>(machine.errors.size()))
        .end();
    json.key("points").begin_array();
  }
  std::uint64_t points = 0, passed = 0;
  Solver solver(*plan, tool_of(machine), options, start);
  ProgressBar bar("cl-correct", as_json && !source->single());
  while (!interrupted() && session.out.ok() && !session.has(Exit::outside) && source->next(session)) {
    const TipAndAxis wanted = {source->pose().position, source->pose().direction.stableNormalized()};
    const std::optional<Pose> ideal = solver.ideal(wanted);
    const CorrectedCl cl = correct_cl(ideal.value_or(Pose{}), wanted, deviations.values(*source), *sources);
    const InverseResult result = ideal ? solver.actual(cl.asked) : InverseResult{};
    if (result.status == Status::failed) {
      report_point("E-REACH", source->where(), "no commands found for this pose",
                   "the axes of this machine cannot bring the tool there, or not within their travels",
                   session);
      break;
    }
    const std::vector<std::string> outside = outside_travel(machine, result.q);
    if (!outside.empty()) {
      report_point("E-TRAVEL", source->where(), "this pose needs positions outside the travels", "", session);
    }
    if (output && !output->write(csv_row(cl.asked))) session.report(*output->error(), arguments.output);
    const bool limits = setting->limits.given();
    const bool pass = setting->limits.pass(result.residual_position, result.residual_direction);
    ++points;
    if (pass) ++passed;
    if (as_json) {
      write_json_point(json, machine, cl, result, outside, limits ? std::optional(pass) : std::nullopt);
      if (json.pending() > kWriteAt) session.out.write(json.take());
    } else {
      session.out.write(point_text(machine, cl, result));
      if (limits) session.out.write(pass ? "  pass\n" : "  FAIL\n");
    }
    bar.show(source->bytes_read(), source->bytes_total());
  }

  const bool complete = !interrupted() && !session.has(Exit::invalid) && !session.has(Exit::internal) &&
                        !session.has(Exit::outside);
  if (session.strict && setting->limits.given() && passed != points) session.note(Exit::warnings);
  if (output && complete && !output->publish()) session.report(*output->error(), arguments.output);
  if (as_json) {
    json.end();
    write_path(json, machine, solver.report());
    if (setting->limits.given()) json.member("pass", passed == points && complete);
    json.member("complete", complete).end();
    session.out.write(json.take());
  } else if (!source->single()) {
    session.out.write(path_text(machine, solver.report()));
  }
}

}  // namespace

Verb cl_correct_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand(
      "cl-correct", "cutter locations that make up for measured deviations of gear and tool");
  auto arguments = std::make_shared<ClCorrectArguments>();
  add_common_options(*command, arguments->common, session);
  add_pose_options(*command, arguments->poses);
  command
      ->add_option("--deviations", arguments->deviations,
                   "CSV of one row, for all poses: gear_static_x_um .. tool_motion_c_urad")
      ->type_name("FILE");
  command
      ->add_option("--sources", arguments->sources,
                   "what counts where the machine file has errors of the same side: deviations, model, both")
      ->check(one_of({"deviations", "model", "both"}));
  command->add_option("-o,--output", arguments->output, "the corrected poses: x_mm,y_mm,z_mm,i,j,k")
      ->type_name("FILE");
  command->add_option("--lock", arguments->lock, "axes that stay where --near says: Z1,B1")
      ->type_name("AXIS,..")
      ->allow_extra_args(false);
  add_method_option(*command, arguments->method);
  return {command, [arguments, &session] { cl_correct(*arguments, session); }};
}

}  // namespace abbe::app
