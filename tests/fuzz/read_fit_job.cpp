#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>

#include "abbe/fit/fit_job.h"
#include "abbe/fit/joint_fit.h"

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

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto fetch = [](const std::string& path) -> std::optional<std::string> {
    if (path == "m.toml") return kMachine;
    // Every name is another file, or the second one would be a copy.
    return path.size() < 32 ? std::optional("# " + path + "\n" + kRuns) : std::nullopt;
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
  return 0;
}
