// inspect: measured points of a part against its nominal surface, as a measuring machine judges them.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/evaluate/monte_carlo.h"
#include "abbe/report/json_writer.h"
#include "abbe/report/part_figure.h"
#include "command_line.h"
#include "common.h"
#include "number_check.h"
#include "output_file.h"
#include "part_source.h"
#include "progress.h"
#include "verbs.h"

namespace abbe::app {
namespace {

constexpr std::size_t kReport = 256;  // points between two looks at the clock
constexpr double ppm = 1e-6;

struct InspectArguments {
  std::string surface, points, fit = "none", svg, csv;
  PointColumns columns;
  double ball_mm = 0, noise_um = 0, size_um = 0, scale_ppm = 0, beside_mm = 0.1;

  [[nodiscard]] bool probes() const {
    return ball_mm != 0 || noise_um != 0 || size_um != 0 || scale_ppm != 0;
  }
  std::optional<double> limit_um;
  std::uint64_t seed = 1;
  bool json = false;
};

BestFit fit_of(const std::string& name) {
  return name == "rigid" ? BestFit::rigid : name == "shift" ? BestFit::shift : BestFit::none;
}

/// Takes the probe's ball off (its centres were recorded), and adds what a measuring machine with these
/// errors would:
///     q' = (1 + scale) q + (size + noise - R) n
/// False: interrupted.
bool probe(const InspectArguments& arguments, const NearestPoint& nominal,
           std::vector<TouchedPoint>& points) {
  if (!arguments.probes()) return true;
  RandomStream random(arguments.seed);
  ProgressBar bar("probe", true, "M points");
  const Progress progress = bar.callback();
  std::size_t done = 0;
  for (TouchedPoint& point : points) {
    if (++done % kReport == 0 && !progress(done, points.size())) return false;
    point.measured *= 1 + arguments.scale_ppm * ppm;
    const SurfaceFoot foot =
        point.target ? nominal.from(*point.target, point.measured) : nominal(point.measured);
    const double noise = arguments.noise_um > 0 ? random.normal() * arguments.noise_um * um : 0;
    point.measured += (arguments.size_um * um + noise - arguments.ball_mm) * foot.at.normal;
  }
  return true;
}

/// A part of which no point counts has not passed.
bool passes(const Inspection& inspection, std::size_t above) {
  return above == 0 && inspection.figures.count > 0;
}

std::string text_of(const InspectArguments& arguments, const Inspection& inspection, std::size_t above) {
  std::string text = fmt::format("{} against {}\n", arguments.points, arguments.surface);
  if (fit_of(arguments.fit) == BestFit::none) {
    text += "  no fit: the datum is that of the points\n";
  } else {
    const Vec3 shift = inspection.shift / um, turn = inspection.turn / urad;
    text += fmt::format("  best fit, least squares of the deviations, {} of {} motions told\n",
                        inspection.rank, arguments.fit == "rigid" ? 6 : 3);
    text += fmt::format("    shift x {:+.3f}  y {:+.3f}  z {:+.3f} um", shift.x(), shift.y(), shift.z());
    text += fmt::format(",  turn x {:+.2f}  y {:+.2f}  z {:+.2f} urad\n", turn.x(), turn.y(), turn.z());
  }
  if (arguments.noise_um > 0)
    text += fmt::format("  probing noise added: {} um standard deviation, seed {}\n", arguments.noise_um,
                        arguments.seed);
  if (arguments.size_um != 0 || arguments.scale_ppm != 0)
    text += fmt::format("  probing errors added: {:+} um along every normal, lengths {:+} ppm\n",
                        arguments.size_um, arguments.scale_ppm);
  text += figures_text(inspection.figures);
  if (inspection.figures.beside > 0)
    text += fmt::format("  {} points beside the patch do not count\n", inspection.figures.beside);
  if (arguments.limit_um)
    text += fmt::format("  {} points beyond +-{} um: {}\n", above, *arguments.limit_um,
                        passes(inspection, above) ? "pass" : "fail");
  return text;
}

std::string json_of(const InspectArguments& arguments, const Inspection& inspection, std::size_t above) {
  JsonWriter json;
  json.begin_object().member("format", 1).member("verb", "inspect");
  json.member("surface", arguments.surface).member("points_file", arguments.points);
  json.key("fit").begin_object();
  json.member("kind", arguments.fit).member("rank", inspection.rank).member("settled", inspection.settled);
  json.member("shift_mm", inspection.shift).member("turn_rad", inspection.turn).end();
  json.key("probe").begin_object(JsonWriter::Layout::one_line);
  json.member("radius_mm", arguments.ball_mm)
      .member("noise_mm", arguments.noise_um * um)
      .member("size_mm", arguments.size_um * um)
      .member("scale_ppm", arguments.scale_ppm)
      .member("seed", arguments.seed)
      .end();
  write_figures(json, inspection.figures);
  if (arguments.limit_um) json.member("pass", passes(inspection, above));
  json.key("points").begin_array();
  for (const InspectedPoint& point : inspection.points) {
    json.begin_object(JsonWriter::Layout::one_line);
    json.member("measured_mm", point.measured)
        .member("nominal_mm", point.foot.at.p)
        .member("normal", point.foot.at.normal);
    json.member("u", point.foot.place.u).member("v", point.foot.place.v);
    json.member("deviation_mm", point.foot.deviation)
        .member("linear_mm", point.linear)
        .member("used", point.used)
        .end();
  }
  json.end().end();
  return json.take() + "\n";
}

std::string csv_of(const Inspection& inspection) {
  std::string text = "x,y,z,xn,yn,zn,deviation_um,linear_um,used\n";
  for (const InspectedPoint& point : inspection.points) {
    const Vec3 &x = point.measured, &p = point.foot.at.p;
    text +=
        fmt::format("{:.7f},{:.7f},{:.7f},{:.7f},{:.7f},{:.7f},{:.4f},{:.4f},{}\n", x.x(), x.y(), x.z(),
                    p.x(), p.y(), p.z(), point.foot.deviation / um, point.linear / um, point.used ? 1 : 0);
  }
  return text;
}

void warn(const InspectArguments& arguments, const Inspection& inspection, Session& session) {
  const auto warning = [&](const char* code, std::string message, const char* why, const char* fix) {
    session.report(
        Diagnostic{Severity::warning, code, {arguments.points, 0, 0, 0, {}}, std::move(message), why, fix});
  };
  if (inspection.figures.beside > 0)
    warning("W-PART-BESIDE",
            fmt::format("{} points are beside the patch, or at a place without a normal",
                        inspection.figures.beside),
            "they do not count", "check units and datum, or a larger --beside-mm");
  if (inspection.figures.creased > 0)
    warning("W-PART-CREASE",
            fmt::format("{} points lie beside a crease of the surface", inspection.figures.creased),
            "a crease has no normal: their deviation is the distance, with the sign of that side",
            "judge the faces beside the crease one by one");
  if (!inspection.settled)
    warning("W-PART-FIT", "the best fit does not come to rest", "the points do not fix the part",
            "measure on more of the surface");
}

void run_inspect(const InspectArguments& arguments, Session& session) {
  const auto surface = load_surface(arguments.surface, session);
  if (!surface) return;
  const NearestPoint nominal(*surface);
  auto points = load_points(arguments.points, arguments.columns, nominal, session);
  if (!points) return;
  if (!probe(arguments, nominal, *points)) return;
  const Inspection inspection = [&] {
    ProgressBar bar("inspect", true, "M points");
    return inspect_points(nominal, *points, fit_of(arguments.fit), arguments.beside_mm, bar.callback());
  }();
  if (inspection.stopped) return;
  std::size_t above = 0;
  for (const InspectedPoint& point : inspection.points)
    if (point.used && arguments.limit_um && std::abs(point.foot.deviation) > *arguments.limit_um * um)
      ++above;
  warn(arguments, inspection, session);
  const std::string svg = arguments.svg.empty() ? "" : figure_of_inspection(*surface, inspection);
  const std::string csv = arguments.csv.empty() ? "" : csv_of(inspection);
  if (!write_outputs({{"--svg", arguments.svg, svg}, {"--csv", arguments.csv, csv}},
                     {arguments.surface, arguments.points}, session))
    return;
  if (session.strict && arguments.limit_um && !passes(inspection, above)) session.note(Exit::warnings);
  session.out.write(arguments.json ? json_of(arguments, inspection, above)
                                   : text_of(arguments, inspection, above));
}

}  // namespace

Verb inspect_verb(Command& program, Session& session) {
  auto arguments = std::make_shared<InspectArguments>();
  Command* verb = program.add_subcommand(
      "inspect", "measured points of a part against its nominal surface: deviations, profile, best fit");
  verb->add_option("surface", arguments->surface, "nominal surface")->required()->type_name("FILE");
  verb->add_option("points", arguments->points,
                   "measured points: CSV of `abbe machine` or a measuring machine, mm")
      ->required()
      ->type_name("FILE");
  verb->add_option("--columns", arguments->columns.measured, "names of the columns of measured x, y, z")
      ->capture_default_str();
  const Option* const target =
      verb->add_option(
              "--target-columns", arguments->columns.target,
              "names of the columns of nominal x, y, z; without the option the file may lack xn, yn, zn")
          ->capture_default_str();
  verb->add_option("--fit", arguments->fit, "best fit of the points to the surface")
      ->check(one_of({"none", "shift", "rigid"}))
      ->capture_default_str();
  verb->add_option("--probe-radius-mm", arguments->ball_mm,
                   "the points are centres of a probe of this radius")
      ->check(number_in(0.0, 100.0));
  verb->add_option("--probe-um", arguments->noise_um,
                   "adds random probing errors along the normal of this standard deviation")
      ->check(number_in(0.0, 1e3));
  verb->add_option(
          "--probe-size-um", arguments->size_um,
          "adds this probing error to every point, + = out of the material: a stylus taken too small")
      ->check(number_in(-1e3, 1e3));
  verb->add_option("--probe-scale-ppm", arguments->scale_ppm,
                   "adds an error of the scales: lengths from the origin are read this much too long")
      ->check(number_in(-1e4, 1e4));
  verb->add_option("--seed", arguments->seed, "of the probing errors")->capture_default_str();
  verb->add_option("--beside-mm", arguments->beside_mm, "points farther beside the patch do not count")
      ->check(number_in(0.0, 1e3))
      ->capture_default_str();
  verb->add_option("--limit-um", arguments->limit_um, "pass or fail: largest deviation of a point")
      ->check(not_negative());
  verb->add_option("--svg", arguments->svg, "colour map of the deviations (SVG)")->type_name("FILE");
  verb->add_option("--csv", arguments->csv, "every point with its deviation (CSV)")->type_name("FILE");
  verb->add_flag("--json", arguments->json, "JSON on standard output");
  verb->add_flag("--strict", session.strict, "warnings and points beyond the limit end with exit code 4");
  return {verb, [arguments, target, &session] {
            arguments->columns.target_needed = target->count() > 0;
            run_inspect(*arguments, session);
          }};
}

}  // namespace abbe::app
