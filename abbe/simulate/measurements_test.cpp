#include "abbe/simulate/measurements.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <variant>

#include "abbe/chain/predict.h"
#include "abbe/fit/errors_file.h"
#include "abbe/fit/joint_fit.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

constexpr const char* kMachine = R"(format = 1
[machine]
name = "hidden"
chain = "w X b Y Z t"
[axis.X]
range = [-200, 300]
errors_seen = "tool"
[axis.Y]
range = [-200, 200]
[axis.Z]
range = [-150, 150]
[tool]
origin = [0, 0, 300]
length = 120
)";
constexpr const char* kErrors = R"([errors]
EXX = { forward = { poly = [0.8, 0.03, -4e-5] }, backward = { poly = [-0.8, 0.03, -4e-5] } }
EBX = { poly = [0, -0.04, 3e-5] }
EYY = { poly = [0, -0.02, 3e-5] }
EC0Y = 24
)";
constexpr const char* kJob = R"(format = 1
machine = "m.toml"
[[square]]
name = "granite"
deviation = 12
u = 1
[[run]]
file = "exx.csv"
error = "EXX"
optic = [0, 0, 90]
temperature = 22
expansion_ppm = 11.5
[[run]]
file = "ebx.csv"
error = "EBX"
[[run]]
file = "eyx.csv"
error = "EYX"
square = "granite"
[[run]]
file = "exy.csv"
error = "EXY"
square = "granite"
sign = "reversed"
[[run]]
file = "eyy.csv"
error = "EYY"
)";

using Files = std::map<std::string, std::string>;

FileFetcher fetcher(const Files& files) {
  return [&files](const std::string& path) -> std::optional<std::string> {
    const auto found = files.find(path);
    return found == files.end() ? std::nullopt : std::optional(found->second);
  };
}

Machine read(const std::string& text) { return *read_machine({"m.toml", text}, std::nullopt, {}).value; }

Files simulate(std::uint64_t seed) {
  Files files = {{"m.toml", kMachine}};
  const Parsed<FitJob> job =
      plan_fit_job({"job.toml", kJob}, fetcher(files), {.targets = 9, .runs = 3, .bidirectional = true});
  EXPECT_TRUE(job.value) << (job.diagnostics.empty() ? "" : to_text(job.diagnostics.front()));
  const Parsed<Observations> planned = observations_of(*job.value);
  for (const SimulatedFile& file :
       simulate_measurements(*job.value, *planned.value, read(std::string(kMachine) + kErrors), {}, seed))
    files[file.path] = file.text;
  return files;
}

TEST(SimulateMeasurements, FitFindsTheHiddenMachine) {
  const Files files = simulate(3);
  const Parsed<FitJob> job = read_fit_job({"job.toml", kJob}, fetcher(files));
  ASSERT_TRUE(job.value) << to_text(job.diagnostics.front());
  const Parsed<Observations> observations = observations_of(*job.value);
  const Parsed<Unknowns> unknowns = unknowns_of(*job.value, *observations.value);
  const FitResult result = fit_jointly(*job.value, *observations.value, *unknowns.value);
  EXPECT_NEAR(result.variance_ratio, 1, 0.5);
  ASSERT_EQ(result.locations.size(), 1U);
  EXPECT_EQ(result.locations[0].name, "EC0Y");
  EXPECT_NEAR(result.locations[0].value, 24, 5 * result.locations[0].u);
  EXPECT_NEAR(result.locations[0].u, 1, 0.7);  // mostly the square's
  EXPECT_NEAR(result.functions[0].reversal[0], 1.6, 0.3);
  const Parsed<Machine> found =
      read_machine({"m.toml", kMachine}, MachineText{"e.toml", write_errors_file(*job.value, result)}, {});
  ASSERT_TRUE(found.value);
  const Plan hidden = std::get<Plan>(make_plan(read(std::string(kMachine) + kErrors), {}));
  const Plan fitted = std::get<Plan>(make_plan(*found.value, {}));
  const auto along_x = [&](const Plan& plan, double x) {
    Query query;
    query.q = {x, 0, 0};
    query.tool = tool_of(*found.value);
    return actual_tip(plan, query).x();
  };
  // 22 degC would add 11.5 um over the travel: it must have been taken off.
  EXPECT_NEAR(along_x(fitted, 300) - along_x(fitted, -200), along_x(hidden, 300) - along_x(hidden, -200),
              1.2 * um);
}

TEST(SimulateMeasurements, SameSeedSameFiles) {
  EXPECT_EQ(simulate(5), simulate(5));
  EXPECT_NE(simulate(5), simulate(6));
}

}  // namespace
}  // namespace abbe
