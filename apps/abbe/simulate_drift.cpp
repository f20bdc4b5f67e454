#include <fmt/core.h>

#include <memory>
#include <optional>
#include <string>

#include "abbe/simulate/drift.h"
#include "common.h"
#include "number_check.h"
#include "simulate.h"
#include "simulated_job.h"

namespace abbe::app {
namespace {

struct SimulateDriftArguments {
  std::string job, errors;
  double hours = 6, step = 60, noise_um = 0.3, noise_arcsec = 0.5, noise_kelvin = 0.02, start = 20;
  std::uint64_t seed = 1;
  bool force = false;
};

void run_simulate_drift(const SimulateDriftArguments& arguments, Session& session) {
  const auto job = planned_job(arguments.job, {}, session);
  if (!job) return;
  if (job->drifts.empty() || job->thermal.sensors.empty()) {
    session.report(option_error("JOB", "no [[drift]], or no sensors under [thermal]",
                                "name the logs and the sensors that are to be written"));
    return;
  }
  const auto hidden = hidden_machine(*job, arguments.errors, session);
  if (!hidden) return;
  constexpr double kHour = 3600;
  DriftScenario scenario;
  scenario.duration = arguments.hours * kHour;
  scenario.step = arguments.step;
  scenario.length = arguments.noise_um * um;
  scenario.angle = arguments.noise_arcsec * arcsec;
  scenario.temperature = arguments.noise_kelvin;
  scenario.start = arguments.start;
  if (scenario.duration / scenario.step > 1e5) {
    session.report(option_error("--step-s", "more than 100000 rows", "a longer step, or fewer hours"));
    return;
  }
  const auto files = simulate_drift(*job, *hidden, scenario, arguments.seed);
  if (files.empty()) {
    session.report(option_error("--errors", "the hidden errors need a sensor that the job does not name",
                                "add it to sensors under [thermal]"));
    return;
  }
  if (!publish_simulated(files, arguments.force, session)) return;
  session.out.write(fmt::format("{} logs of {:g} h on {}\n", files.size(), arguments.hours, hidden->name));
}

}  // namespace

Verb simulate_drift_verb(Command& simulate, Session& session) {
  Command* command = simulate.add_subcommand(
      "drift",
      "writes the logs that a job of `fit` names: temperatures and drift of a machine with hidden errors");
  auto arguments = std::make_shared<SimulateDriftArguments>();
  command->add_option("job", arguments->job, "job for `fit` (TOML)")->required()->type_name("JOB");
  command->add_option("--errors", arguments->errors, "errors file of the hidden machine")
      ->required()
      ->type_name("FILE");
  const auto number = [&](const char* name, double& to, const char* what, double least) {
    command->add_option(name, to, what)->check(number_in(least, 1e6))->type_name("NUMBER");
  };
  number("--hours", arguments->hours, "length of each log (6)", 0.1);
  number("--step-s", arguments->step, "time between rows (60)", 0.1);
  number("--noise-um", arguments->noise_um, "of displacements (0.3)", 0);
  number("--noise-arcsec", arguments->noise_arcsec, "of tilts (0.5)", 0);
  number("--noise-kelvin", arguments->noise_kelvin, "of temperatures (0.02)", 0);
  command->add_option("--start", arguments->start, "temperature of everything when a log begins, degC (20)")
      ->check(number_in(0.0, 50.0));
  command->add_option("--seed", arguments->seed, "of the random numbers (1)")->type_name("N");
  command->add_flag("--force", arguments->force, "overwrites files that are there");
  return {command, [arguments, &session] { run_simulate_drift(*arguments, session); }};
}

}  // namespace abbe::app
