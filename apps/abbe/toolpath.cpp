// toolpath: passes of a ball-end mill over a surface, as CL data, program or table.

#include <fmt/format.h>

#include <memory>
#include <string>

#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"
#include "abbe/surface/write_tool_path.h"
#include "command_line.h"
#include "common.h"
#include "number_check.h"
#include "output_file.h"
#include "part_source.h"
#include "profile_options.h"
#include "progress.h"
#include "verbs.h"

namespace abbe::app {
namespace {

struct ToolpathArguments {
  std::string surface, cutter = "ball:3", along = "v", program, cl, csv;
  double scallop_um = 5, step_mm = 0, tolerance_um = 1;
  bool one_way = false, json = false;
  ToolPathText text;
  ProfileArguments profile;
};

/// What a fault is called, and what helps.
struct FaultWords {
  const char *code, *fix;
};
FaultWords words_of(ToolPathFault::Kind kind) {
  switch (kind) {
    case ToolPathFault::Kind::curvature:
      return {"E-PATH-CURVATURE", "a cutter of a smaller radius"};
    case ToolPathFault::Kind::pole:
      return {"E-PATH-POLE", "a part of the surface that ends before the pole, or a net without one"};
    case ToolPathFault::Kind::undercut:
      return {"E-PATH-UNDERCUT", "turn the part, or correct `outward` in the surface file"};
    case ToolPathFault::Kind::gouge:
      return {"E-PATH-GOUGE",
              "a smaller cutter, a part of the surface, or passes along the crease with --one-way"};
    case ToolPathFault::Kind::endless:
    case ToolPathFault::Kind::stopped:
      break;
  }
  return {"E-PATH-ENDLESS", "a larger scallop or step, or a larger tolerance"};
}

void report(const ToolPathFault& fault, const std::string& surface, Session& session) {
  if (fault.kind == ToolPathFault::Kind::stopped) {
    session.note(Exit::interrupted);
    return;
  }
  const FaultWords words = words_of(fault.kind);
  session.report(Diagnostic{Severity::error,
                            words.code,
                            {surface, 0, 0, 0, {}},
                            to_text(fault),
                            "the part would not be the one that is meant",
                            words.fix});
}

std::string csv_of(const ToolPath& path) {
  std::string text = "pass,x,y,z,i,j,k,tip_x,tip_y,tip_z\n";
  for (std::size_t k = 0; k < path.passes.size(); ++k) {
    for (const ToolContact& point : path.passes[k].points) {
      const Vec3 &c = point.contact, &n = point.normal, &t = point.tip;
      text += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.8f},{:.8f},{:.8f},{:.6f},{:.6f},{:.6f}\n", k + 1, c.x(),
                          c.y(), c.z(), n.x(), n.y(), n.z(), t.x(), t.y(), t.z());
    }
  }
  return text;
}

std::string answer_of(const ToolpathArguments& arguments, const ToolPath& path) {
  const double minutes = path.length / arguments.text.feed;
  if (!arguments.json)
    return fmt::format(
        "{}: {} passes, {} points, {:.2f} m of feed, {:.1f} min\n  step between passes {:.3f} to {:.3f} mm\n",
        arguments.surface, path.passes.size(), path.points, path.length / metre, minutes, path.least_step,
        path.most_step);
  JsonWriter json;
  json.begin_object().member("format", 1).member("verb", "toolpath").member("surface", arguments.surface);
  json.member("radius_mm", arguments.text.radius)
      .member("passes", static_cast<std::uint64_t>(path.passes.size()));
  json.member("points", static_cast<std::uint64_t>(path.points)).member("length_mm", path.length);
  json.member("least_step_mm", path.least_step).member("most_step_mm", path.most_step).end();
  return json.take() + "\n";
}

void run_toolpath(ToolpathArguments arguments, Session& session) {
  const auto surface = load_surface(arguments.surface, session);
  const auto cutter = read_cutter(arguments.cutter, 0, session);
  const auto profile = load_profile(arguments.profile, session);
  if (cutter && !cutter->is_ball())
    session.report(option_error("--cutter", "tool paths are for ball-end mills", "write ball:3"));
  if (!surface || !cutter || !cutter->is_ball() || profile == nullptr) return;
  arguments.text.name = surface->name.empty() ? arguments.surface : surface->name;
  arguments.text.radius = cutter->radius;
  const ToolPathJob job{cutter->radius,     arguments.step_mm > 0 ? 0 : arguments.scallop_um * um,
                        arguments.step_mm,  arguments.along == "v",
                        !arguments.one_way, arguments.tolerance_um * um};
  if (job.scallop >= job.radius) {
    session.report(
        option_error("--scallop-um", "the scallop is as high as the ball", "a few micrometres are usual"));
    return;
  }
  std::variant<ToolPath, ToolPathFault> made;
  {
    ProgressBar bar(fmt::format("toolpath {}", arguments.surface), true, "M");
    made = make_tool_path(NearestPoint(*surface), job, bar.callback());
  }
  if (const auto* fault = std::get_if<ToolPathFault>(&made)) {
    report(*fault, arguments.surface, session);
    return;
  }
  const ToolPath& path = std::get<ToolPath>(made);
  const auto program = arguments.program.empty() ? std::optional<std::string>("")
                                                 : write_program(path, arguments.text, *profile);
  if (!program) {
    session.report(option_error("--dialect",
                                "this control has no code for plain motions in mm, or for --tool with G43 H",
                                "another profile, or no --tool"));
    return;
  }
  const std::string cl = arguments.cl.empty() ? "" : write_cl(path, arguments.text);
  const std::string csv = arguments.csv.empty() ? "" : csv_of(path);
  if (!write_outputs({{"--output", arguments.program, *program},
                      {"--cl", arguments.cl, cl},
                      {"--csv", arguments.csv, csv}},
                     {arguments.surface}, session))
    return;
  session.out.write(answer_of(arguments, path));
}

}  // namespace

Verb toolpath_verb(Command& program, Session& session) {
  auto arguments = std::make_shared<ToolpathArguments>();
  Command* verb = program.add_subcommand(
      "toolpath", "passes of a ball-end mill over a surface: CL data, program, contact points");
  verb->add_option("surface", arguments->surface, "nominal surface")->required()->type_name("FILE");
  verb->add_option("--cutter", arguments->cutter, "ball:3: radius, mm")->capture_default_str();
  verb->add_option("--scallop-um", arguments->scallop_um, "height of what is left between passes")
      ->check(number_in(1e-3, 1e4))
      ->capture_default_str();
  verb->add_option("--step-mm", arguments->step_mm, "constant distance of passes, in place of the scallop")
      ->check(number_in(1e-4, 1e3))
      ->excludes(verb->get_option("--scallop-um"));
  verb->add_option("--tolerance-um", arguments->tolerance_um, "of the chords")
      ->check(number_in(0.01, 1e3))
      ->capture_default_str();
  verb->add_option("--along", arguments->along, "parameter along which passes run")
      ->check(one_of({"u", "v"}))
      ->capture_default_str();
  verb->add_flag("--one-way", arguments->one_way, "all passes in one direction, lifted between");
  verb->add_option("--feed", arguments->text.feed, "mm/min")
      ->check(number_in(0.1, 1e6))
      ->capture_default_str();
  verb->add_option("--clearance-mm", arguments->text.clearance, "over the highest point, between passes")
      ->check(number_in(0.0, 1e4))
      ->capture_default_str();
  verb->add_option("--tool", arguments->text.tool,
                   "number of the tool to load; without it the tool is in the spindle")
      ->check(whole_in(0, 99999));
  verb->add_option("-o,--output", arguments->program, "program for the control of --dialect")
      ->type_name("FILE");
  verb->add_option("--cl", arguments->cl, "CL data (APT)")->type_name("FILE");
  verb->add_option("--csv", arguments->csv, "contact points, normals and tips (CSV)")->type_name("FILE");
  add_profile_options(*verb, arguments->profile);
  verb->add_flag("--json", arguments->json, "JSON on standard output");
  return {verb, [arguments, &session] { run_toolpath(*arguments, session); }};
}

}  // namespace abbe::app
