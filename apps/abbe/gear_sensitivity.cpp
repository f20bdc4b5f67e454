#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/gear/sensitivity.h"
#include "gear_machine.h"
#include "gear_report.h"
#include "number_check.h"
#include "progress.h"
#include "text.h"

namespace abbe::app {
namespace {

struct GearSensitivityArguments {
  GearMachineArguments machine;
  std::string of = "given";
  double unit_um = 10, unit_urad = 10;
};

constexpr double kSeen = 0.0005 * um;  // what would be printed as 0.00

bool is_seen(const GearEffects& effects) {
  double most = std::max({effects.profile_form, effects.helix_form, effects.f_p, effects.F_p, effects.F_r,
                          std::abs(effects.depth)});
  for (std::size_t side = 0; side < 2; ++side)
    for (const TeethFigure& figure : {effects.profile_slope[side], effects.helix_slope[side]})
      most = std::max({most, std::abs(figure.mean), figure.range});
  return most > kSeen;
}

std::string text_of(const GearSensitivityArguments& arguments, const std::vector<SensitivityRow>& rows) {
  std::string text = arguments.of == "given"
                         ? std::string("every error of the machine file by itself, um\n")
                         : fmt::format("one unit of every deviation by itself ({:g} um or {:g} urad), um\n",
                                       arguments.unit_um, arguments.unit_urad);
  text +=
      "slopes: mean over the teeth, right and left flank, +- half of what differs from tooth to tooth\n\n";
  text += fmt::format("{:<16}{:>21}{:>21}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}\n", "", "f_H_alpha", "f_H_beta",
                      "f_f_a", "f_f_b", "f_p", "F_p", "F_r", "depth");
  std::string nothing;
  for (const SensitivityRow& row : rows) {
    const GearEffects& e = row.effects;
    if (!is_seen(e)) {
      nothing += (nothing.empty() ? "" : " ") + row.name;
      continue;
    }
    const auto slope = [](const std::array<TeethFigure, 2>& figure) {
      return fmt::format("{:>7}{:>7} +-{:>4}", um_text(figure[0].mean), um_text(figure[1].mean),
                         um_text(std::max(figure[0].range, figure[1].range) / 2, 1));
    };
    text += fmt::format("{:<16}{:>21}{:>21}", row.name, slope(e.profile_slope), slope(e.helix_slope));
    for (const double value : {e.profile_form, e.helix_form, e.f_p, e.F_p, e.F_r, e.depth})
      text += fmt::format("{:>8}", um_text(value));
    text += '\n';
  }
  if (!nothing.empty()) text += "nothing on the gear: " + nothing + "\n";
  return text;
}

void write_slopes(JsonWriter& json, const char* name, const std::array<TeethFigure, 2>& figure) {
  json.key(name).begin_array(JsonWriter::Layout::one_line);
  for (const TeethFigure& side : figure)
    json.begin_object().member("mean_um", side.mean / um).member("range_um", side.range / um).end();
  json.end();
}

std::string json_of(const GearSensitivityArguments& arguments, const GearOnMachine& loaded,
                    const std::vector<SensitivityRow>& rows) {
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "gear sensitivity", loaded.setting.machine);
  json.member("of", arguments.of)
      .member("unit_um", arguments.unit_um)
      .member("unit_urad", arguments.unit_urad);
  json.key("rows").begin_array();
  for (const SensitivityRow& row : rows) {
    json.begin_object().member("name", row.name).member("rotation", row.rotation);
    write_slopes(json, "f_H_alpha", row.effects.profile_slope);
    write_slopes(json, "f_H_beta", row.effects.helix_slope);
    json.member("f_f_alpha_um", row.effects.profile_form / um)
        .member("f_f_beta_um", row.effects.helix_form / um);
    json.member("f_p_um", row.effects.f_p / um).member("F_p_um", row.effects.F_p / um);
    json.member("F_r_um", row.effects.F_r / um).member("depth_um", row.effects.depth / um).end();
  }
  json.end().end();
  return json.take() + "\n";
}

void run_gear_sensitivity(const GearSensitivityArguments& arguments, Session& session) {
  const std::optional<GearOnMachine> loaded = load_gear_on_machine(arguments.machine, session);
  if (!loaded) return;
  const GearJob& job = loaded->gear.job;
  const WheelInGap& wheel = loaded->gear.wheel;
  const auto inspection = GearInspection::make(job.gear, wheel, job.evaluation);
  if (!inspection) return;
  const SensitivityUnits units{arguments.unit_um * um, arguments.unit_urad * urad};
  ProgressBar bar("gear sensitivity", true, "M errors");
  std::vector<SensitivityRow> rows;
  if (arguments.of == "poses") {
    rows = pose_sensitivity(job, wheel, *inspection, units);
  } else if (arguments.of == "units") {
    rows = machine_sensitivity(loaded->setting.machine, job, wheel, loaded->motion, *inspection, units,
                               bar.callback());
  } else {
    rows = error_budget(loaded->setting.machine, job, wheel, loaded->motion, *inspection,
                        cut_options(*loaded), bar.callback());
  }
  if (interrupted()) return;
  session.out.write(arguments.machine.common.json ? json_of(arguments, *loaded, rows)
                                                  : text_of(arguments, rows));
}

}  // namespace

Verb gear_sensitivity_verb(Command& gear, Session& session) {
  Command* command = gear.add_subcommand("sensitivity", "which error makes which deviation of the gear");
  auto arguments = std::make_shared<GearSensitivityArguments>();
  add_gear_machine_options(*command, arguments->machine, session);
  command
      ->add_option("--of", arguments->of,
                   "given: errors of the machine file; units: one unit of every error of the chain; poses: "
                   "one unit of "
                   "the 24 deviations of gear and wheel (given)")
      ->check(one_of({"given", "units", "poses"}))
      ->type_name("WHAT");
  command->add_option("--unit-um", arguments->unit_um, "unit of displacements (10)")
      ->check(above_zero())
      ->type_name("UM");
  command->add_option("--unit-urad", arguments->unit_urad, "unit of rotations (10)")
      ->check(above_zero())
      ->type_name("URAD");
  return {command, [arguments, &session] { run_gear_sensitivity(*arguments, session); }};
}

}  // namespace abbe::app
