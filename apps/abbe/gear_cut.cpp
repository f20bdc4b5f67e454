#include <fmt/core.h>

#include <memory>
#include <string>
#include <variant>

#include "abbe/core/units.h"
#include "abbe/gear/exact_cut.h"
#include "abbe/gear/gear_cl.h"
#include "abbe/report/gear_figure.h"
#include "gear_machine.h"
#include "gear_report.h"
#include "output_file.h"
#include "progress.h"
#include "text.h"

namespace abbe::app {
namespace {

constexpr double kClTolerance = 0.5 * um;
constexpr std::size_t kEveryPoint = 5;  // of the traces is written with --points

struct GearCutArguments {
  GearMachineArguments machine;
  std::string correction = "none", method = "newton", cl, motions, points, svg;
  std::vector<std::string> lock;
  std::vector<int> teeth;
};

/// What the verb answers with.
struct CutAnswer {
  const GearOnMachine& loaded;
  const GearCutArguments& arguments;
  MachineCut cut;
  GearFigures figures;
  std::optional<double> second_order;
};

/// False after reporting why commands cannot be corrected.
bool set_correction(const GearCutArguments& arguments, const GearOnMachine& loaded, CutOptions& options,
                    Session& session) {
  options.correction = correction_of(arguments.correction);
  if (options.correction == CutCorrection::none) return true;
  Diagnostics findings;
  const AxisSet locked = read_lock(loaded.setting.machine, arguments.lock, findings);
  session.report(findings);
  if (has_errors(findings)) return false;
  const std::optional<AxisSet> free = free_axes_or_report(loaded.setting.machine, locked, session);
  if (!free) return false;
  options.free = *free;
  options.solver.locked = locked;
  options.solver.method = method_of(arguments.method);
  return options.correction != CutCorrection::pose ||
         method_fits_or_report(loaded.setting, options.solver.method, *free, session);
}

bool teeth_exist(const GearCutArguments& arguments, const GearJob& job, Session& session) {
  for (const int tooth : arguments.teeth)
    if (tooth > job.gear.spec.teeth) {
      session.report(option_error("--teeth",
                                  fmt::format("the gear has {} teeth, not {}", job.gear.spec.teeth, tooth),
                                  "teeth are counted from 1"));
      return false;
    }
  return true;
}

/// Traces of the shown teeth, as `gear correct` reads them.
std::string points_csv(const CutAnswer& answer, const GearInspection& inspection) {
  const GearJob& job = answer.loaded.gear.job;
  std::string csv = "tooth,flank,roll_mm,z_mm,deviation_um\n";
  const double reference = job.gear.base_radius * job.gear.reference_roll;
  for (const int tooth : shown_teeth(job, answer.arguments.teeth))
    for (const Flank flank : {Flank::right, Flank::left}) {
      const FlankTraces traces = inspection.traces(answer.cut.deviations, tooth - 1, flank);
      const auto row = [&](double roll, double z, double f) {
        csv += fmt::format("{},{},{:.6f},{:.6f},{}\n", tooth, flank == Flank::right ? "right" : "left", roll,
                           z, um_text(f, 5));
      };
      for (std::size_t i = 0; i < traces.profile.size(); i += kEveryPoint)
        row(traces.roll_length[i], 0, traces.profile[i]);
      for (std::size_t i = 0; i < traces.helix.size(); i += kEveryPoint)
        row(reference, traces.z[i], traces.helix[i]);
    }
  return csv;
}

std::string chart_of(const CutAnswer& answer, const GearInspection& inspection) {
  const GearJob& job = answer.loaded.gear.job;
  GearChart chart;
  chart.title = fmt::format("{} on {}", job.gear.spec.name, answer.loaded.setting.machine.name);
  chart.remark = fmt::format("module {:g} mm, {} teeth, helix {:g} deg, face {:g} mm; correction: {}",
                             job.gear.spec.module, job.gear.spec.teeth,
                             job.gear.spec.hand * job.gear.spec.helix_angle / deg, job.gear.spec.face_width,
                             answer.arguments.correction);
  chart.figures = answer.figures;
  for (const int tooth : shown_teeth(job, answer.arguments.teeth)) {
    if (chart.teeth.size() == kMostChartTeeth) break;
    chart.teeth.push_back({tooth,
                           {inspection.traces(answer.cut.deviations, tooth - 1, Flank::right),
                            inspection.traces(answer.cut.deviations, tooth - 1, Flank::left)}});
  }
  return figure_of_gear(job, chart);
}

std::string text_of(const CutAnswer& answer) {
  const GearJob& job = answer.loaded.gear.job;
  std::string text = text_of_gear(job, answer.loaded.gear.wheel);
  const double seconds =
      answer.loaded.motion.time(job.cutting, answer.loaded.motion.gaps() - 1, answer.loaded.motion.nodes - 1);
  text += fmt::format("machine       {}, {}; {} gaps in {:.0f} s; correction: {}\n\n",
                      answer.loaded.setting.machine.name, answer.loaded.setting.machine.chain,
                      answer.loaded.motion.gaps(), seconds, answer.arguments.correction);
  text += text_of_figures(job, answer.figures, answer.arguments.teeth);
  if (answer.cut.outside) text += "\nextrapolated: errors held beyond their last value\n";
  if (answer.second_order)
    text += fmt::format("\nproducts of errors, neglected above: {} um at most where looked at\n",
                        um_text(*answer.second_order, 3));
  return text;
}

std::string json_of(const CutAnswer& answer) {
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "gear cut", answer.loaded.setting.machine);
  write_gear(json, answer.loaded.gear.job, answer.loaded.gear.wheel);
  json.member("model", to_string(answer.loaded.setting.model))
      .member("correction", answer.arguments.correction);
  json.member("places", static_cast<std::uint64_t>(answer.cut.commands.size()))
      .member("partial", static_cast<std::uint64_t>(answer.cut.partial))
      .member("failed", static_cast<std::uint64_t>(answer.cut.failed))
      .member("outside", answer.cut.outside);
  write_figures(json, answer.loaded.gear.job, answer.figures, answer.arguments.teeth);
  json.member("F_r_um", answer.figures.F_r / um).key("second_order_um");
  if (answer.second_order) {
    json.value(*answer.second_order / um);
  } else {
    json.null();
  }
  json.end();
  return json.take() + "\n";
}

void warn(const CutAnswer& answer, Session& session) {
  const std::string& machine = answer.arguments.machine.common.machine;
  if (answer.cut.partial + answer.cut.failed > 0) {
    Diagnostic partial;
    partial.severity = Severity::warning;
    partial.code = "W-GEAR-PARTIAL";
    partial.place.file = machine;
    partial.message = fmt::format(
        "at {} of {} places the axes cannot restore the wheel's position, at {} no correction was found",
        answer.cut.partial, answer.cut.commands.size(), answer.cut.failed);
    partial.fix = "--correct flank makes the best of the axes there are";
    session.report(partial);
  }
  report_second_order(answer.second_order, machine, session);
}

/// False after reporting that corrected commands would rest on errors nobody has measured.
bool within_calibration(const GearCutArguments& arguments, const MachineCut& cut, Session& session) {
  if (!cut.outside || correction_of(arguments.correction) == CutCorrection::none) return true;
  report_outside(arguments.machine.common.machine, session);
  return false;
}

void run_gear_cut(const GearCutArguments& arguments, Session& session) {
  const std::optional<GearOnMachine> loaded = load_gear_on_machine(arguments.machine, session);
  if (!loaded || !teeth_exist(arguments, loaded->gear.job, session)) return;
  CutOptions options = cut_options(*loaded);
  if (!set_correction(arguments, *loaded, options, session)) return;
  const std::optional<GearInspection> inspection =
      GearInspection::make(loaded->gear.job.gear, loaded->gear.wheel, loaded->gear.job.evaluation);
  if (!inspection) return;
  ProgressBar bar("gear cut", true, "M gaps");
  auto made = cut_on_machine(loaded->setting.machine, loaded->gear.job, loaded->gear.wheel, loaded->motion,
                             options, bar.callback());
  if (!std::holds_alternative<MachineCut>(made) || std::get<MachineCut>(made).stopped) return;
  if (!within_calibration(arguments, std::get<MachineCut>(made), session)) return;
  if (!within_travels(*loaded, std::get<MachineCut>(made).commands, session)) return;
  CutAnswer answer{*loaded, arguments, std::get<MachineCut>(std::move(made)), {}, {}};
  answer.figures = inspection->figures(answer.cut.deviations);
  answer.second_order = second_order(loaded->gear.job.gear, loaded->gear.wheel, answer.cut.deviations);
  const auto text_if = [](const std::string& path, auto make) {
    return path.empty() ? std::string() : make();
  };
  if (!write_outputs(
          {{"--cl", arguments.cl,
            text_if(arguments.cl,
                    [&] {
                      return write_gear_cl(loaded->gear.job, loaded->gear.wheel, loaded->motion.axis_sign,
                                           kClTolerance);
                    })},
           {"--motions", arguments.motions,
            text_if(arguments.motions, [&] { return motions_csv(*loaded, answer.cut.commands); })},
           {"--svg", arguments.svg, text_if(arguments.svg, [&] { return chart_of(answer, *inspection); })},
           {"--points", arguments.points,
            text_if(arguments.points, [&] { return points_csv(answer, *inspection); })}},
          loaded->inputs, session))
    return;
  warn(answer, session);
  session.out.write(arguments.machine.common.json ? json_of(answer) : text_of(answer));
}

}  // namespace

Verb gear_cut_verb(Command& gear, Session& session) {
  Command* command = gear.add_subcommand(
      "cut", "cuts a gear on a machine with errors and measures it: profile, helix, pitch, runout");
  auto arguments = std::make_shared<GearCutArguments>();
  add_gear_machine_options(*command, arguments->machine, session);
  command->add_option("--correct", arguments->correction, "commands sent: none, pose, flank (none)")
      ->check(one_of({"none", "pose", "flank"}))
      ->type_name("WHAT");
  command->add_option("--lock", arguments->lock, "axes that no correction moves: Z1,B1")
      ->type_name("AXIS,..")
      ->allow_extra_args(false);
  add_method_option(*command, arguments->method);
  command
      ->add_option("--teeth", arguments->teeth,
                   "teeth that are shown: 1,25,48,72 (the gear file's, else all)")
      ->delimiter(',')
      ->check(whole_in(1, 2000))
      ->type_name("N,..");
  command->add_option("--cl", arguments->cl, "the nominal cut as CL data")->type_name("FILE");
  command->add_option("--motions", arguments->motions, "axis commands of every gap, as sent: CSV")
      ->type_name("FILE");
  command->add_option("--points", arguments->points, "deviations of the shown teeth along their traces: CSV")
      ->type_name("FILE");
  command->add_option("--svg", arguments->svg, "gear chart: profiles, helices, pitch, runout (SVG)")
      ->type_name("FILE");
  return {command, [arguments, &session] { run_gear_cut(*arguments, session); }};
}

}  // namespace abbe::app
