#include <fmt/core.h>

#include <array>
#include <memory>
#include <string>

#include "abbe/core/units.h"
#include "abbe/gear/flank_tolerances.h"
#include "common.h"
#include "gear.h"
#include "gear_report.h"
#include "output_file.h"

namespace abbe::app {
namespace {

struct GearMakeArguments {
  std::string gear, points, profile;
  int rolls = 41, heights = 11;
  bool json = false;
};

constexpr int kMostPoints = 200'000;  // of a flank: 40 MB of text

constexpr std::array kFlanks = {Flank::right, Flank::left};

std::string name_of(Flank flank) { return flank == Flank::right ? "right" : "left"; }

/// Design points of both flanks of gap 1, in the gap's frame.
std::string points_csv(const LoadedGear& gear, const GearMakeArguments& arguments) {
  std::string csv = "flank,roll_mm,z_mm,x_mm,y_mm,nx,ny,nz\n";
  for (const Flank flank : kFlanks)
    for (const double roll : even_rolls(gear.job.gear, arguments.rolls))
      for (const double z : even_heights(gear.job.gear, arguments.heights)) {
        const FlankPoint at = flank_point(gear.job.gear, flank, roll, z, Modified::all);
        csv += fmt::format("{},{:.6f},{:.6f},{:.9f},{:.9f},{:.12f},{:.12f},{:.12f}\n", name_of(flank),
                           gear.job.gear.base_radius * roll, z, at.position.x(), at.position.y(),
                           at.normal.x(), at.normal.y(), at.normal.z());
      }
  return csv;
}

/// The wheel's axial profile, in the order of the roll angles.
std::string profile_csv(const LoadedGear& gear) {
  std::string csv = "flank,roll_mm,axial_mm,radius_mm,contact_height_mm\n";
  for (const Flank flank : kFlanks)
    for (const WheelContact& contact : gear.wheel.of(flank))
      csv += fmt::format("{},{:.6f},{:.9f},{:.9f},{:.9f}\n", name_of(flank),
                         gear.job.gear.base_radius * contact.roll, contact.axial, contact.radius, contact.z);
  return csv;
}

std::string tolerances_text(const GearJob& job) {
  if (!job.tolerance_class) return {};
  const std::optional<FlankTolerances> t = flank_tolerances(job.gear, *job.tolerance_class);
  if (!t) return "tolerances    none: the gear is outside the range of ISO 1328-1\n";
  std::string text = fmt::format("tolerances    class {}:", *job.tolerance_class);
  for (const WorstFigure& figure : worst_of({}))
    text += fmt::format(" {} {}", figure.name, um_text(rounded_tolerance((*t).*figure.which), 1));
  return text + " um\n";
}

void run_gear_make(const GearMakeArguments& arguments, Session& session) {
  if (arguments.heights > kMostPoints / arguments.rolls) {
    session.report(option_error("--rolls",
                                fmt::format("{} x {} points of a flank", arguments.rolls, arguments.heights),
                                fmt::format("at most {} with --heights", kMostPoints)));
    return;
  }
  const std::optional<LoadedGear> gear = load_gear(arguments.gear, session);
  if (!gear) return;
  if (!write_outputs(
          {{"--points", arguments.points, arguments.points.empty() ? "" : points_csv(*gear, arguments)},
           {"--profile", arguments.profile, profile_csv(*gear)}},
          {arguments.gear}, session))
    return;
  if (!arguments.json) {
    session.out.write(text_of_gear(gear->job, gear->wheel) + tolerances_text(gear->job));
    return;
  }
  JsonWriter json;
  json.begin_object().member("format", 1).member("verb", "gear make");
  write_gear(json, gear->job, gear->wheel);
  json.key("tolerances_um").begin_object();
  if (const auto t = flank_tolerances(gear->job.gear, gear->job.tolerance_class.value_or(0)))
    for (const WorstFigure& figure : worst_of({}))
      json.member(figure.name, rounded_tolerance((*t).*figure.which) / um);
  json.end().end();
  session.out.write(json.take() + "\n");
}

}  // namespace

Verb gear_make_verb(Command& gear, Session& session) {
  Command* command =
      gear.add_subcommand("make", "a gear from its drawing: flanks, tolerances, the wheel for it");
  auto arguments = std::make_shared<GearMakeArguments>();
  command->add_option("gear", arguments->gear, "gear file (TOML)")->required()->type_name("GEAR");
  command->add_option("--points", arguments->points, "points and normals of both flanks of gap 1: CSV")
      ->type_name("FILE");
  command->add_option("--rolls", arguments->rolls, "points from form to tip (41)")
      ->check(whole_in(2, 10'000))
      ->type_name("N");
  command->add_option("--heights", arguments->heights, "points over the face (11)")
      ->check(whole_in(2, 10'000))
      ->type_name("N");
  command->add_option("--profile", arguments->profile, "axial profile of the wheel: CSV")->type_name("FILE");
  command->add_flag("--json", arguments->json, "JSON on standard output");
  command->add_flag("--strict", session.strict, "warnings end with exit code 4");
  return {command, [arguments, &session] { run_gear_make(*arguments, session); }};
}

}  // namespace abbe::app
