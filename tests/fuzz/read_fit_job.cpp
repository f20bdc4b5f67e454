#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>

#include "abbe/fit/drift_courses.h"
#include "abbe/fit/errors_file.h"
#include "abbe/fit/fit_job.h"
#include "abbe/fit/joint_fit.h"
#include "abbe/fit/thermal_fit.h"
#include "abbe/machine/uncertainty_modes.h"

// Jobs of fit: any bytes give a job or diagnostics; a job that is read is fitted without a number that is not
// one.

namespace {

constexpr const char* kMachine =
    "format = 1\n[machine]\nname = \"m\"\nchain = \"w X b Y Z t\"\n[axis.X]\nrange = [0, 500]\nerrors_seen = "
    "\"tool\"\n"
    "[axis.Y]\nrange = [0, 400]\n[axis.Z]\nrange = [-300, 0]\n[tool]\norigin = [0, 0, 500]\nlength = 150\n";
constexpr const char* kRuns =
    "target [mm],run,direction,deviation "
    "[um]\n0,1,+,0\n100,1,+,1\n200,1,+,3\n200,1,-,2\n100,1,-,1\n0,1,-,-1\n";

constexpr const char* kLog =
    "time [min],T1 [degC],T2 [degC],Z1 [um],Z2 "
    "[um]\n0,20,20,0,1\n1,21,20,1,0\n2,22,21,2,0\n3,23,21,3,1\n4,24,22,4,0\n"
    "5,24,22,4,0\n6,24,23,5,0\n7,23,23,4,1\n8,22,23,3,0\n9,22,22,2,0\n10,21,22,2,0\n11,20,21,1,0\n";
constexpr const char* kBalls =
    "X [mm],Y [mm],Z [mm],ball,x [um],y [um],z [um]\n0,0,0,1,1,2,3\n0,0,0,1,2,2,3\n";

/// Logs for names with d, balls for names with b, runs for all others.
const char* contents(const std::string& path) {
  return path.find('d') != std::string::npos ? kLog : path.find('b') != std::string::npos ? kBalls : kRuns;
}

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto fetch = [](const std::string& path) -> std::optional<std::string> {
    if (path == "m.toml") return kMachine;
    // Every name is another file, or the second one would be a copy.
    return path.size() < 32 ? std::optional("# " + path + "\n" + contents(path)) : std::nullopt;
  };
  const abbe::Parsed<abbe::FitJob> job = abbe::read_fit_job({"job.toml", text}, fetch);
  require(job.value.has_value() != abbe::has_errors(job.diagnostics));
  if (!job.value) return 0;
  const auto observations = abbe::observations_of(*job.value);
  require(observations.value.has_value() != abbe::has_errors(observations.diagnostics));
  if (!observations.value) return 0;
  const auto unknowns = abbe::unknowns_of(*job.value, *observations.value);
  require(unknowns.value.has_value() != abbe::has_errors(unknowns.diagnostics));
  if (!unknowns.value) return 0;
  const abbe::FitResult result = abbe::fit_jointly(*job.value, *observations.value, *unknowns.value);
  for (const abbe::FoundFunction& found : result.functions) require(found.mean.allFinite() && found.u >= 0);
  const auto courses = abbe::drift_courses(*job.value);
  require(courses.value.has_value() != abbe::has_errors(courses.diagnostics));
  if (!courses.value) return 0;
  const abbe::ThermalFit thermal = abbe::fit_thermal(job.value->thermal, *courses.value);
  for (const abbe::ThermalModel& model : thermal.models) require(std::isfinite(model.u + model.left));
  // What is written is read, if the fit is one.
  if (result.status != abbe::FitResult::Status::ok || !thermal.finite) return 0;
  const std::string errors = abbe::write_errors_file(*job.value, result, thermal) +
                             abbe::write_uncertainty_modes(*job.value, result, thermal);
  const auto machine = abbe::read_machine({"m.toml", kMachine}, abbe::MachineText{"e.toml", errors}, {});
  if (machine.value) (void)abbe::read_uncertainty_modes(*machine.value, {"e.toml", errors}, {});
  return 0;
}
