#include "abbe/simulate/drift.h"

#include <gtest/gtest.h>

#include <map>
#include <variant>

#include "abbe/chain/predict.h"
#include "abbe/fit/drift_courses.h"
#include "abbe/fit/errors_file.h"
#include "abbe/fit/thermal_fit.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

constexpr const char* kMachine = R"(format = 1
[machine]
name = "warm mill"
chain = "w X b Y Z S t"
[axis.X]
errors_seen = "tool"
[tool]
origin = [0, 0, 300]
length = 120
)";
constexpr const char* kHidden = R"([errors]
TZS = { poly = [0, 3.1], of = "spindle_slow", reference = 20 }
TYS = [{ poly = [0, -0.8], of = "column", reference = 20 }, { poly = [0, 0.5], of = "spindle", reference = 20 }]
TAS = { poly = [0, 1.7], of = "column", reference = 20 }
[sensors]
spindle_slow = { of = "spindle", lag = 2400 }
)";
constexpr const char* kJob = R"(format = 1
machine = "m.toml"
[thermal]
errors = ["TYS", "TZS", "TAS"]
sensors = ["spindle", "column", "hall"]
[[drift]]
file = "warm.csv"
readings = { Z1 = { direction = "Z" }, Y1 = { direction = "Y" }, Y2 = { direction = "Y", optic = [0, 0, 200] } }
[[drift]]
file = "other.csv"
use = "validation"
readings = { Z1 = { direction = "Z", sign = "reversed" }, Y1 = { direction = "Y" }, Y2 = { direction = "Y", optic = [0, 0, 200] } }
)";

using Files = std::map<std::string, std::string>;

FileFetcher fetch_from(const Files& files) {
  return [files](const std::string& path) -> std::optional<std::string> {
    const auto found = files.find(path);
    return found == files.end() ? std::nullopt : std::optional(found->second);
  };
}

Machine hidden_machine() {
  return *read_machine({"m.toml", std::string(kMachine) + kHidden}, std::nullopt, {}).value;
}

Files measured(const std::string& job, std::uint64_t seed) {
  Files files = {{"m.toml", kMachine}};
  const auto planned = plan_fit_job({"job.toml", job}, fetch_from(files), {});
  EXPECT_TRUE(planned.value);
  for (const SimulatedFile& file : simulate_drift(*planned.value, hidden_machine(), {}, seed))
    files[file.path] = file.text;
  return files;
}

TEST(SimulateDrift, FitFindsTheHiddenDrift) {
  const Files files = measured(kJob, 5);
  const auto job = read_fit_job({"job.toml", kJob}, fetch_from(files));
  ASSERT_TRUE(job.value) << to_text(job.diagnostics.front());
  const auto courses = drift_courses(*job.value);
  ASSERT_TRUE(courses.value);
  const ThermalFit fit = fit_thermal(job.value->thermal, *courses.value);
  ASSERT_EQ(fit.models.size(), 3U);
  for (const ThermalModel& model : fit.models) {
    EXPECT_FALSE(model.misfit) << model.name << " " << model.left << " " << model.noise;
    EXPECT_LT(*model.validated, 1.5 * model.noise) << model.name;
    EXPECT_GT(*model.validated_before, 2 * *model.validated) << model.name;
  }
  // The errors file as predict reads it, at temperatures of its own: sign, side, units and lag.
  const std::string errors = write_errors_file(*job.value, {}, fit);
  const auto found = read_machine({"m.toml", kMachine}, MachineText{"errors.toml", errors}, {});
  ASSERT_TRUE(found.value) << to_text(found.diagnostics.front()) << errors;
  Environment warm = {{"spindle", 23}, {"spindle_slow", 22.5}, {"column", 26}, {"hall", 20.2}};
  for (const LaggedSensor& sensor : found.value->lagged_sensors) {
    EXPECT_EQ(sensor.of, "spindle");
    EXPECT_NEAR(sensor.lag, 2400, 120);
    warm[sensor.name] = 22.5;
  }
  const auto truth = make_plan(hidden_machine(), warm), fitted = make_plan(*found.value, warm);
  ASSERT_TRUE(std::holds_alternative<Plan>(fitted)) << errors;
  Query query;
  query.tool = tool_of(*found.value);
  const Vec3 expected = actual_tip(std::get<Plan>(truth), query),
             got = actual_tip(std::get<Plan>(fitted), query);
  EXPECT_GT((expected - nominal_tip(std::get<Plan>(truth), query)).norm(), 7 * um);
  EXPECT_LT((expected - got).norm(), 0.5 * um) << errors;
}

TEST(SimulateDrift, SameSeedSameLogs) {
  EXPECT_EQ(measured(kJob, 3), measured(kJob, 3));
  EXPECT_NE(measured(kJob, 3), measured(kJob, 4));
}

TEST(SimulateDrift, TwoSensorsTellTilt) {
  std::string one = kJob;
  one.replace(one.find("optic = [0, 0, 200]"), 19, "optic = [90, 0, 0]");
  const auto job = read_fit_job({"job.toml", one}, fetch_from(measured(kJob, 5)));
  ASSERT_TRUE(job.value);
  const auto courses = drift_courses(*job.value);
  ASSERT_FALSE(courses.value);
  EXPECT_EQ(courses.diagnostics.front().code, "E-THERMAL-RANK");
}

TEST(SimulateDrift, WrongLogsAreRefused) {
  const Files good = measured(kJob, 5);
  const std::string header = "time [s],spindle [degC],column [degC],hall [degC],Z1 [um],Y1 [um],Y2 [um]\n";
  const auto code_of = [&](const std::string& log) {
    Files files = good;
    files["warm.csv"] = log;
    const auto job = read_fit_job({"job.toml", kJob}, fetch_from(files));
    return job.value ? std::string("read") : job.diagnostics.front().code;
  };
  std::string rows, hot, back;
  for (int i = 0; i < 20; ++i) {
    rows += std::to_string(i) + ",20,20,20,1,2,3\n";
    hot += std::to_string(i) + ",20,20000,20,1,2,3\n";
    back += std::to_string(i % 7) + ",20,20,20,1,2,3\n";
  }
  EXPECT_EQ(code_of(header + rows), "read");
  EXPECT_EQ(code_of(header + hot), "E-THERMAL-TEMPERATURE");
  EXPECT_EQ(code_of(header + back), "E-DRIFT-TIME");
  EXPECT_EQ(code_of(header + "0,20,20,20,1,2,3\n"), "E-JOB-EMPTY");
  EXPECT_EQ(code_of(header + "0,20,nan,20,1,2,3\n"), "E-MEASURED-CELL");
  EXPECT_EQ(code_of(good.at("other.csv")), "E-JOB-TWICE");
  EXPECT_EQ(code_of("time [s],spindle [degC]\n0,20\n1,20\n"), "E-JOB-EMPTY");
  std::string other = header;
  other.replace(other.find("hall"), 4, "wall");
  EXPECT_EQ(code_of(other + rows), "E-JOB-KIND");
}

}  // namespace
}  // namespace abbe
