#include "inverse_gcode.h"

#include <fmt/format.h>

#include <variant>

#include "abbe/cl/emit_gcode.h"
#include "abbe/core/file.h"
#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/report/header.h"
#include "abbe/report/json_writer.h"
#include "number_check.h"
#include "progress.h"

namespace abbe::app {
namespace {

/// The poses of a CSV file as CL data: the first one is reached by a rapid motion.
std::optional<SpoolFile> as_cl_data(const PoseArguments& poses, double length_unit, double feed,
                                    Session& session) {
  std::optional<PoseSource> source = PoseSource::open(poses, length_unit, {}, session);
  if (!source) return std::nullopt;
  auto created = SpoolFile::create("-");
  if (const auto* error = std::get_if<FileError>(&created)) {
    session.report(*error, "temporary file");
    return std::nullopt;
  }
  SpoolFile file = std::move(std::get<SpoolFile>(created));
  bool written = file.write(fmt::format("UNITS/MM\nMULTAX/ON\nFEDRAT/{},MMPM\nRAPID\n", to_shortest(feed)));
  while (written && source->next(session)) {
    const Vec3 p = source->pose().position, u = source->pose().direction.normalized();
    written = file.write(fmt::format("GOTO/{},{},{},{},{},{}\n", to_shortest(p.x()), to_shortest(p.y()),
                                     to_shortest(p.z()), to_shortest(u.x()), to_shortest(u.y()),
                                     to_shortest(u.z())));
  }
  if (!written || !file.write("FINI\n") || !file.flush()) {
    session.report(*file.error(), "temporary file");
    return std::nullopt;
  }
  if (session.has(Exit::invalid) || session.has(Exit::internal)) return std::nullopt;
  return file;
}

Exit exit_of(const GcodeReport& report) {
  for (const Diagnostic& d : report.diagnostics) {
    if (d.code == "E-FILE" || d.code == "E-WRITE") return Exit::internal;
    if (d.code == "E-MACHINE" || d.code == "E-EMPTY") return Exit::invalid;
  }
  return report.out_of_volume ? Exit::outside : Exit::refused;
}

void tell(const GcodeReport& report, const CommonArguments& common, const std::string& output,
          Session& session) {
  if (common.json) {
    JsonWriter json;
    json.begin_object();
    json.member("format", 1).member("verb", "inverse").member("output", output);
    json.member("motions", report.motions).member("blocks", report.blocks).member("arcs", report.arcs);
    json.member("max_correction_um", report.max_correction / um)
        .member("max_turn_urad", report.max_turn / urad)
        .end();
    session.out.write(json.take() + "\n");
    return;
  }
  session.out.write(
      fmt::format("{}: {} motions in {} blocks; corrections up to {:.1f} um and {:.1f} urad of the axes\n",
                  output, report.motions, report.blocks, report.max_correction / um, report.max_turn / urad));
}

std::vector<std::string> header_of(const GcodeJob& job, const Plan& plan, const Setting& setting,
                                   const ExpansionArguments& expansion) {
  ProgramReport report;
  report.verb = "inverse";
  report.program_version = ABBE_VERSION;
  report.input_name = job.name;
  report.machine = &plan.machine();
  report.model = setting.model;
  report.environment = setting.environment;
  add_to_environment(expansion, report.environment);
  report.setup = job.setup;
  report.datum = job.probed_datum ? DatumRule::probed : DatumRule::ideal;
  report.tolerance = job.tolerance;
  // Without errors it is no compensated program, and may be compensated.
  return job.ideal ? std::vector<std::string>{"(ABBE INVERSE OF THE IDEAL MACHINE)"} : header_lines(report);
}

}  // namespace

void add_gcode_options(Command& verb, GcodeArguments& a) {
  const char* group = "A program in place of a list (--emit gcode)";
  verb.add_option("--emit", a.emit, "gcode: write a program of axis words; --poses may then be CL data")
      ->check(one_of({"gcode"}))
      ->group(group);
  verb.add_option("--profile", a.profile, "control the program is for")
      ->check(one_of({"linuxcnc"}))
      ->capture_default_str()
      ->group(group);
  verb.add_option("-o,--output", a.output, "where the program goes, or - for standard output")->group(group);
  verb.add_option("--offset", a.offsets, "G54=X..,Y..,Z..: where the part stands; it is taken off the words")
      ->group(group);
  verb.add_option("--tools", a.tools, "LinuxCNC tool table, in mm")->group(group);
  verb.add_option("--gauge", a.gauges, "gauge length of a tool, e.g. T3=112.4 (repeatable)")->group(group);
  verb.add_option("--datum", a.datum, "probed or ideal, as in compensate")
      ->check(one_of({"probed", "ideal"}))
      ->capture_default_str()
      ->group(group);
  verb.add_option("--feed", a.feed, "mm/min, for poses from CSV")->check(number_in(1e-3, 1e6))->group(group);
  verb.add_option("--tolerance-um", a.tolerance_um, "how far the tip may leave its path between blocks")
      ->check(number_in(0.01, 1000.0))
      ->capture_default_str()
      ->group(group);
  verb.add_option("--max-correction-um", a.max_correction_um, "larger corrections are refused")
      ->check(number_in(1.0, 1e5))
      ->capture_default_str()
      ->group(group);
  verb.add_option("--units", a.units, "CL data without UNITS: mm or inch")
      ->check(one_of({"mm", "inch"}))
      ->group(group);
  add_cl_options(verb, a.cl, false);
}

void write_gcode(const CommonArguments& common, const PoseArguments& poses, bool ideal,
                 const GcodeArguments& a, Session& session) {
  ProgramArguments program;
  program.common = common;
  program.offsets = a.offsets;
  program.gauges = a.gauges;
  program.tools = a.tools;
  program.datum = a.datum;
  program.tolerance_um = a.tolerance_um;
  program.max_correction_um = a.max_correction_um;
  program.cl = a.cl;
  program.cl.near = poses.near;
  program.profile.dialect = "cl";
  program.profile.units = a.units;
  if (a.output.empty() || poses.poses.empty() || (a.output == "-" && common.json)) {
    session.report(option_error("--emit",
                                a.output.empty()      ? "no -o: where does the program go?"
                                : poses.poses.empty() ? "no --poses to write a program of"
                                                      : "standard output cannot hold the program and --json",
                                "abbe inverse MACHINE --poses part.cls --emit gcode -o part.ngc"));
    return;
  }
  if (poses.expansion.given() && (ideal || is_cl_data("", poses.poses))) {
    Diagnostic error = option_error(
        "--workpiece-temperature",
        ideal ? "a program of the ideal machine is not for one temperature" : "CL data are not scaled",
        "poses as CSV (--poses part.csv), without --ideal");
    error.code = "E-EXPANSION";
    return session.report(error);
  }
  const auto setting = load_program_setting(program, poses.poses, session);
  if (!setting) return;
  GcodeJob job;
  job.path = job.name = poses.poses;
  job.setup = setting->job.setup;
  job.conventions = setting->job.cl->conventions;
  job.start = setting->job.cl->start;
  job.ideal = ideal;
  job.probed_datum = setting->job.datum == DatumRule::probed;
  job.tolerance = setting->job.tolerance;
  job.max_correction = setting->job.max_correction;
  job.header = header_of(job, setting->plan, setting->setting, poses.expansion);
  std::optional<SpoolFile> converted;
  if (!is_cl_data("", poses.poses)) {
    if (!a.feed)
      return session.report(
          option_error("--feed", "poses from CSV have no feed", "give it in mm/min: --feed 500"));
    converted = as_cl_data(poses, setting->setting.machine.units.length, *a.feed, session);
    if (!converted) return;
    job.path = converted->temporary_path();
  }
  for (const std::string& input : setting->setting.machine.files) {
    if (same_file(a.output, input))
      return session.report(
          option_error("-o", "it names an input", "an input is never overwritten: name another file"));
  }
  if (same_file(a.output, poses.poses))
    return session.report(
        option_error("-o", "it names an input", "an input is never overwritten: name another file"));
  auto created = SpoolFile::create(a.output);
  if (const auto* error = std::get_if<FileError>(&created)) return session.report(*error, a.output);
  auto& spool = std::get<SpoolFile>(created);
  GcodeReport report;
  {
    ProgressBar bar(fmt::format("inverse {}", poses.poses));
    report = emit_gcode(setting->plan, job, spool, bar.callback());
  }
  session.report(report.diagnostics, exit_of(report));
  if (!report.complete) return session.note(report.stopped ? Exit::interrupted : exit_of(report));
  if (!spool.publish()) return session.report(*spool.error(), a.output);
  if (a.output != "-") tell(report, common, a.output, session);
}

}  // namespace abbe::app
