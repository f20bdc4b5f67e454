#include <fmt/core.h>

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/fit/observations.h"
#include "abbe/simulate/measurements.h"
#include "common.h"
#include "number_check.h"
#include "simulate.h"
#include "simulated_job.h"

namespace abbe::app {
namespace {

struct SimulateMeasurementsArguments {
  std::string job, errors;
  MeasurementPlan plan;
  bool one_way = false, force = false;
  double noise_um = 0.3, noise_arcsec = 0.5;
  std::uint64_t seed = 1;
};

void run_simulate_measurements(SimulateMeasurementsArguments arguments, Session& session) {
  arguments.plan.bidirectional = !arguments.one_way;
  const auto job = planned_job(arguments.job, arguments.plan, session);
  if (!job) return;
  const Parsed<Observations> planned = observations_of(*job);
  session.report(planned.diagnostics);
  if (!planned.value) return;
  const std::optional<Machine> hidden = hidden_machine(*job, arguments.errors, session);
  if (!hidden) return;
  if (!std::holds_alternative<Plan>(make_plan(*hidden, {}))) {
    session.report(
        option_error("--errors", "the errors need sensors", "instruments are read at one temperature"));
    return;
  }
  SimulatedNoise noise;
  noise.length = arguments.noise_um * um;
  noise.angle = arguments.noise_arcsec * arcsec;
  const auto files = simulate_measurements(*job, *planned.value, *hidden, noise, arguments.seed);
  if (!publish_simulated(files, arguments.force, session)) return;
  session.out.write(fmt::format("{} files of measurements on {}\n", files.size(), hidden->name));
}

}  // namespace

Verb simulate_measurements_verb(Command& simulate, Session& session) {
  Command* command = simulate.add_subcommand(
      "measurements", "writes the files that a job of `fit` names, measured on a machine with hidden errors");
  auto arguments = std::make_shared<SimulateMeasurementsArguments>();
  command->add_option("job", arguments->job, "job for `fit` (TOML)")->required()->type_name("JOB");
  command->add_option("--errors", arguments->errors, "errors file of the hidden machine")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--targets", arguments->plan.targets, "targets of each run, evenly over the travel (11)")
      ->check(whole_in(2, 10'000))
      ->type_name("N");
  command->add_option("--runs", arguments->plan.runs, "runs in each direction (5)")
      ->check(whole_in(1, 1000))
      ->type_name("N");
  command->add_flag("--one-way", arguments->one_way, "increasing positions only");
  command->add_option("--noise-um", arguments->noise_um, "of readings whose entry states no noise (0.3)")
      ->check(not_negative())
      ->type_name("UM");
  command->add_option("--noise-arcsec", arguments->noise_arcsec, "of angles (0.5)")
      ->check(not_negative())
      ->type_name("ARCSEC");
  command->add_option("--seed", arguments->seed, "of the random numbers (1)")->type_name("N");
  command->add_flag("--force", arguments->force, "overwrites files that are there");
  return {command, [arguments, &session] { run_simulate_measurements(*arguments, session); }};
}

}  // namespace abbe::app
