// machine: what a program leaves of a part on the machine as it is.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/part/machined_surface.h"
#include "abbe/pipeline/program_poses.h"
#include "abbe/report/json_writer.h"
#include "command_line.h"
#include "number_check.h"
#include "output_file.h"
#include "part_source.h"
#include "program_options.h"
#include "progress.h"
#include "text.h"
#include "verbs.h"

namespace abbe::app {
namespace {

constexpr std::size_t kReport = 256;  // points between two looks at the clock

struct MachineArguments {
  ProgramArguments program;
  std::string input, surface, cutter = "ball:3", grid = "10x10", points, output;
  double length = 0, reach = 1, noise_um = 0, wear_um_per_m = 0, worn_um = 0, time_step = 10;
  std::uint64_t seed = 1;
  bool clock = false, ideal = false;
};

/// A point asked: where on the nominal surface, and what was found.
struct AskedPoint {
  SurfacePlace place;
  SurfacePoint nominal;
  std::optional<double> deviation;
};

struct MachineAnswer {
  PoseReport program;
  std::vector<AskedPoint> points;
  std::size_t uncut = 0;
  double worn = 0;
  InspectionFigures figures;
};

std::optional<std::vector<AskedPoint>> asked_points(const MachineArguments& arguments,
                                                    const NurbsSurface& surface, Session& session) {
  std::vector<SurfacePlace> places;
  if (arguments.points.empty()) {
    const auto size = read_grid(arguments.grid, session);
    if (!size) return std::nullopt;
    places = cell_places(surface, size->rows, size->columns);
  } else {
    const NearestPoint nominal(surface);
    const auto points = load_points(arguments.points, {}, nominal, session);
    if (!points) return std::nullopt;
    ProgressBar bar("points", true, "M points");
    const Progress progress = bar.callback();
    for (const TouchedPoint& point : *points) {
      places.push_back(nominal(point.measured).place);
      if (places.size() % kReport == 0 && !progress(places.size(), points->size())) return std::nullopt;
    }
  }
  std::vector<AskedPoint> out;
  for (const SurfacePlace& place : places) out.push_back({place, evaluate(surface, place), std::nullopt});
  return out;
}

PartBox box_of(const std::vector<AskedPoint>& points, double reach) {
  PartBox box{points.front().nominal.p, points.front().nominal.p};
  for (const AskedPoint& point : points)
    box = {box.low.cwiseMin(point.nominal.p), box.high.cwiseMax(point.nominal.p)};
  box.low.array() -= reach;
  box.high.array() += reach;
  return box;
}

Disturbance disturbance_of(const MachineArguments& arguments) {
  return {arguments.noise_um * um, arguments.wear_um_per_m * um / metre, arguments.worn_um * um,
          arguments.seed};
}

PoseJob pose_job(const MachineArguments& arguments, const ProgramSetting& setting) {
  PoseJob job;
  job.path = job.name = arguments.input;
  job.setup = setting.job.setup;
  job.datum = setting.job.datum;
  job.time_step = arguments.time_step;
  if (arguments.clock)
    job.plan_at = [&setting](double seconds) -> std::optional<Plan> {
      Environment environment = setting.setting.environment;
      environment["t"] = seconds;
      auto plan = make_plan(setting.setting.machine, environment, setting.setting.model);
      return std::holds_alternative<Plan>(plan) ? std::optional(std::get<Plan>(std::move(plan)))
                                                : std::nullopt;
    };
  return job;
}

/// Follows the program; nullopt after reporting why not.
std::optional<ToolWay> follow(const MachineArguments& arguments, const ProgramSetting& setting,
                              const Cutter& cutter, MachineAnswer& answer, Session& session) {
  ToolWay way(cutter, disturbance_of(arguments), box_of(answer.points, arguments.reach));
  ProgressBar bar(fmt::format("follow {}", arguments.input));
  answer.program = program_poses(
      setting.plan, pose_job(arguments, setting), [&](const MotionPoses& motion) { way.add(motion); },
      bar.callback());
  using End = PoseReport::End;
  const bool missing = answer.program.end == End::io;
  session.report(answer.program.diagnostics, missing ? Exit::invalid : Exit::refused);
  if (answer.program.end == End::stopped) session.note(Exit::interrupted);
  if (answer.program.end != End::done) return std::nullopt;
  answer.worn = way.worn();
  if (!way.is_full()) return way;
  Diagnostic full =
      option_error("--grid", fmt::format("more than {} pieces of way reach the points", ToolWay::kMostPieces),
                   "ask for points of a part of the surface: --points");
  full.code = "E-PART-SIZE";
  session.report(full);
  return std::nullopt;
}

/// False: interrupted.
bool ask(const MachinedSurface& part, double reach, MachineAnswer& answer) {
  ProgressBar bar("machine", true, "M points");
  const Progress progress = bar.callback();
  std::vector<double> found;
  for (std::size_t k = 0; k < answer.points.size(); ++k) {
    AskedPoint& point = answer.points[k];
    if (point.nominal.is_regular())
      point.deviation = part.deviation(point.nominal.p, point.nominal.normal, reach);
    if (!point.deviation) ++answer.uncut;
    if (k % kReport == kReport - 1 && !progress(k, answer.points.size())) return false;
  }
  std::vector<InspectedPoint> judged;
  for (const AskedPoint& point : answer.points) {
    if (!point.deviation) continue;
    InspectedPoint& one = judged.emplace_back();
    one.foot.deviation = *point.deviation;
    one.linear = std::abs(*point.deviation);
  }
  answer.figures = figures_of(judged);
  return true;
}

void warn(const MachineArguments& arguments, const MachineAnswer& answer, Session& session) {
  const auto warning = [&](const char* code, std::string message, std::string why, std::string fix) {
    session.report(Diagnostic{Severity::warning,
                              code,
                              {arguments.input, 0, 0, 0, {}},
                              std::move(message),
                              std::move(why),
                              std::move(fix)});
  };
  if (answer.uncut > 0)
    warning("W-PART-UNCUT",
            fmt::format("{} of {} points are not cut within {} mm, or have no normal", answer.uncut,
                        answer.points.size(), arguments.reach),
            "they are not part of the figures", "check offset, cutter and surface, or a larger --reach-mm");
  const bool gouged = std::any_of(answer.points.begin(), answer.points.end(), [&](const AskedPoint& p) {
    return p.deviation && *p.deviation <= -arguments.reach;
  });
  if (gouged)
    warning("W-PART-GOUGE", fmt::format("points are cut {} mm deep or deeper", arguments.reach),
            "deeper is not looked at", "check offset, cutter and surface, or a larger --reach-mm");
  if (answer.program.beyond_travel)
    warning("W-PART-TRAVEL", "the program leaves the travels of the machine",
            "no part would come out, and errors are not known there", "check offset and start");
  if (answer.program.outside)
    warning("W-PART-VOLUME", "the program leaves the volume in which the errors are known",
            "errors were held at their ends", "measure a larger volume");
}

std::string csv_of(const MachineAnswer& answer) {
  std::string text = "x,y,z,xn,yn,zn,i,j,k,u,v,deviation_um\n";
  for (const AskedPoint& point : answer.points) {
    if (!point.deviation) continue;
    const Vec3 &p = point.nominal.p, &n = point.nominal.normal, x = p + *point.deviation * n;
    text += fmt::format(
        "{:.7f},{:.7f},{:.7f},{:.7f},{:.7f},{:.7f},{:.9f},{:.9f},{:.9f},{:.9g},{:.9g},{:.4f}\n", x.x(), x.y(),
        x.z(), p.x(), p.y(), p.z(), n.x(), n.y(), n.z(), point.place.u, point.place.v, *point.deviation / um);
  }
  return text;
}

std::string text_of(const MachineArguments& arguments, const Cutter& cutter, const MachineAnswer& answer) {
  const Vec3 datum = answer.program.datum / um;
  std::string text = fmt::format("{} cut by {}: radius {} mm, corner {} mm\n", arguments.surface,
                                 arguments.input, cutter.radius, cutter.corner);
  text += fmt::format("  {} motions, {:.1f} min, {:.2f} m of feed\n", answer.program.motions,
                      answer.program.seconds / 60, answer.program.feed_length / metre);
  text +=
      fmt::format("  datum taken off: x {:+.3f}  y {:+.3f}  z {:+.3f} um\n", datum.x(), datum.y(), datum.z());
  if (answer.worn > 0) text += fmt::format("  cutter worn by {:.3f} um at the end\n", answer.worn / um);
  return text + figures_text(answer.figures);
}

std::string json_of(const MachineArguments& arguments, const Machine& machine, const Cutter& cutter,
                    const MachineAnswer& answer) {
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "machine", machine);
  json.member("surface", arguments.surface).member("program", arguments.input);
  json.key("cutter").begin_object(JsonWriter::Layout::one_line);
  json.member("radius_mm", cutter.radius)
      .member("corner_mm", cutter.corner)
      .member("length_mm", cutter.length)
      .member("worn_mm", answer.worn)
      .end();
  json.member("motions", answer.program.motions).member("poses", answer.program.poses);
  json.member("seconds", answer.program.seconds).member("feed_length_mm", answer.program.feed_length);
  json.member("datum_mm", answer.program.datum).member("uncut", static_cast<std::uint64_t>(answer.uncut));
  write_figures(json, answer.figures);
  json.key("points").begin_array();
  for (const AskedPoint& point : answer.points) {
    json.begin_object(JsonWriter::Layout::one_line);
    json.member("u", point.place.u)
        .member("v", point.place.v)
        .member("nominal_mm", point.nominal.p)
        .member("normal", point.nominal.normal);
    json.key("deviation_mm");
    if (point.deviation)
      json.value(*point.deviation);
    else
      json.null();
    json.end();
  }
  json.end().end();
  return json.take() + "\n";
}

void run_machine(MachineArguments arguments, Session& session) {
  if (!settle_files(arguments.program.common, {&arguments.input}, session)) return;
  if (!arguments.program.report.empty() || !arguments.program.figure.empty()) {
    session.report(option_error(arguments.program.report.empty() ? "--figure" : "--report",
                                "nothing is corrected here", "--json, -o, and `abbe inspect --svg`"));
    return;
  }
  if (arguments.clock) arguments.program.common.set.push_back("t=0");
  auto setting = load_program_setting(arguments.program, arguments.input, session);
  const auto surface = load_surface(arguments.surface, session);
  const auto cutter = read_cutter(arguments.cutter, arguments.length, session);
  if (!setting || !surface || !cutter) return;
  if (setting->job.cl) {
    session.report(option_error("PROGRAM", "CL data have no axis positions",
                                "`abbe inverse --emit gcode` makes a program of them"));
    return;
  }
  if (arguments.ideal) {
    setting->setting.machine.errors.clear();
    auto plan = plan_or_report(setting->setting, setting->setting.environment, session);
    if (!plan) return;
    setting->plan = std::move(*plan);
  }
  MachineAnswer answer;
  auto points = asked_points(arguments, *surface, session);
  if (!points) return;
  answer.points = std::move(*points);
  auto way = follow(arguments, *setting, *cutter, answer, session);
  if (!way || !ask(MachinedSurface(*cutter, way->take()), arguments.reach, answer)) return;
  warn(arguments, answer, session);
  std::vector<std::string> inputs = setting->setting.machine.files;
  for (const std::string& input : {arguments.input, arguments.surface, arguments.points})
    if (!input.empty()) inputs.push_back(input);
  if (!write_outputs({{"--output", arguments.output, arguments.output.empty() ? "" : csv_of(answer)}}, inputs,
                     session))
    return;
  const double most = std::max(std::abs(answer.figures.least), std::abs(answer.figures.most));
  const auto& limits = setting->setting.limits;
  if (answer.program.beyond_travel || answer.program.outside) session.note(Exit::outside);
  if (session.strict && limits.position && (answer.uncut > 0 || most > *limits.position))
    session.note(Exit::warnings);
  session.out.write(arguments.program.common.json
                        ? json_of(arguments, setting->setting.machine, *cutter, answer)
                        : text_of(arguments, *cutter, answer));
}

}  // namespace

Verb machine_verb(Command& program, Session& session) {
  auto arguments = std::make_shared<MachineArguments>();
  Command* verb = program.add_subcommand(
      "machine", "the part that a program leaves on this machine: deviations of its surface");
  add_program_options(*verb, arguments->program, session);
  verb->add_option("program", arguments->input, "program that cuts the surface");
  verb->add_option("--surface", arguments->surface, "nominal surface, in coordinates of the program")
      ->required()
      ->type_name("FILE");
  verb->add_option("--cutter", arguments->cutter, "ball:3, flat:10, bull:10,2: radius, corner radius, mm")
      ->capture_default_str();
  verb->add_option("--cutter-length", arguments->length, "length of the cutter, mm (ten times its radius)")
      ->check(above_zero());
  verb->add_option("--grid", arguments->grid, "points: middles of so many cells along u and v")
      ->capture_default_str();
  verb->add_option("--points", arguments->points, "points: CSV with x,y,z near the surface")
      ->type_name("FILE")
      ->excludes(verb->get_option("--grid"));
  verb->add_option("-o,--output", arguments->output, "machined points for `abbe inspect` (CSV)")
      ->type_name("FILE");
  verb->add_option("--reach-mm", arguments->reach, "how far from the surface material is looked for")
      ->check(number_in(1e-3, 100.0))
      ->capture_default_str();
  verb->add_option("--noise-um", arguments->noise_um,
                   "random motion of the tool, standard deviation per coordinate and motion")
      ->check(number_in(0.0, 1e3));
  verb->add_option("--seed", arguments->seed, "of the noise")->capture_default_str();
  verb->add_option("--wear-um-per-m", arguments->wear_um_per_m, "what the cutter loses per metre of feed")
      ->check(number_in(0.0, 1e3));
  verb->add_option("--worn-um", arguments->worn_um, "what the cutter has lost before")
      ->check(number_in(0.0, 1e3));
  verb->add_flag("--clock", arguments->clock, "t is the time of the program: errors that depend on t drift");
  verb->add_option("--time-step-s", arguments->time_step,
                   "how often the machine is looked at anew with --clock")
      ->check(number_in(0.1, 1e5))
      ->capture_default_str();
  verb->add_flag("--ideal", arguments->ideal, "without errors: what cutter and tool path leave");
  return {verb, [arguments, &session] { run_machine(*arguments, session); }};
}

}  // namespace abbe::app
