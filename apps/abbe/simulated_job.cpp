#include "simulated_job.h"

#include <fmt/core.h>

#include <filesystem>
#include <utility>

#include "abbe/machine/read_machine.h"
#include "common.h"
#include "output_file.h"

namespace abbe::app {
namespace {

/// False after naming a file that is there already.
bool none_exists(const std::vector<SimulatedFile>& files, Session& session) {
  for (const SimulatedFile& file : files) {
    std::error_code error;
    if (!std::filesystem::exists(file.path, error)) continue;
    session.report(option_error("JOB", fmt::format("'{}' is there already", file.path),
                                "--force overwrites it; a real measurement would be lost"));
    return false;
  }
  return true;
}

}  // namespace

std::optional<FitJob> planned_job(const std::string& path, const MeasurementPlan& plan, Session& session) {
  const std::optional<std::string> text = read_input(path, session);
  if (!text) return std::nullopt;
  Parsed<FitJob> job = plan_fit_job({path, *text}, fetch_file, plan);
  session.report(job.diagnostics);
  return std::move(job.value);
}

std::optional<Machine> hidden_machine(const FitJob& job, const std::string& errors, Session& session) {
  Parsed<Machine> machine = read_machine_file(job.machine.files.front(), errors);
  session.report(machine.diagnostics);
  return std::move(machine.value);
}

bool publish_simulated(const std::vector<SimulatedFile>& files, bool force, Session& session) {
  if (!force && !none_exists(files, session)) return false;
  std::vector<OutputText> outputs;
  for (const SimulatedFile& file : files) outputs.push_back({file.path, file.text});
  return publish_texts(outputs, session);
}

}  // namespace abbe::app
