#include "abbe/fit/state_grids.h"

#include <gtest/gtest.h>

#include "abbe/fit/test_hidden_machine.h"

namespace abbe {
namespace {

using namespace test;

/// A fit of the hidden machine whose EXX and EC0Y are `share` of the full ones.
FitResult fit_state(double share, FitJob& job_out) {
  const HiddenMachine hidden(
      three_axis_machine("body"),
      fmt::format("[errors]\nEXX = {{ poly = [0, {}, {}] }}\n", 0.05 * share, 2e-5 * share));
  const Files files = {
      {"hidden.toml", hidden.text},
      {"x.csv", run_file(hidden, 0, 0, spaced_targets(-200, 300, 11), {}, Vec3::Zero(), {})}};
  const auto job = read_job(
      fmt::format("format = 1\nmachine = \"hidden.toml\"\n[[run]]\nfile = \"x.csv\"\nerror = \"EXX\"\nsign = "
                  "\"normal\"\n[functions]\nEXX = {{ form = \"polynomial\", order = 2 }}\n[[value]]\nerror = "
                  "\"EC0Y\"\nvalue = {}\nu = 1\n",
                  10 * share),
      files);
  job_out = *job.value;
  const auto observations = observations_of(*job.value);
  return fit_jointly(*job.value, *observations.value, *unknowns_of(*job.value, *observations.value).value);
}

TEST(StateGrids, GridMeetsEveryStateAndTheirMeanBetween) {
  FitJob job;
  std::vector<ThermalState> states = {
      {18, fit_state(1, job)}, {24, fit_state(2, job)}, {30, fit_state(5, job)}};
  const StateGrids grids = write_state_grids(job, "T1", states);
  ASSERT_EQ(grids.obstacle, "");
  const auto machine =
      read_machine({"m.toml", three_axis_machine("body")}, MachineText{"e.toml", grids.text}, {});
  ASSERT_TRUE(machine.value) << codes(machine.diagnostics) << grids.text;
  const auto x_error = [&](double x, double T) {
    const auto plan = std::get<Plan>(make_plan(*machine.value, {{"T1", T}}));
    Query query;
    query.q[0] = x;
    query.tool = tool_of(*machine.value);
    return (actual_tip(plan, query) - nominal_tip(plan, query))[0];
  };
  const HiddenMachine hidden(three_axis_machine("body"), "[errors]\nEXX = { poly = [0, 0.05, 2e-5] }\n");
  const auto truth = [&](double x) { return hidden.displacement(hidden.query({x}))[0]; };
  for (const double x : {-200.0, -63.0, 150.0, 300.0}) {
    const double slack = 0.01 * um;
    EXPECT_NEAR(x_error(x, 18), truth(x), slack);
    EXPECT_NEAR(x_error(x, 24), 2 * truth(x), slack);
    EXPECT_NEAR(x_error(x, 27), 3.5 * truth(x), slack);
    EXPECT_NEAR(x_error(x, 99), 5 * truth(x), slack);
  }
}

/// A fit of EXX with a reversal of `share` times 3 um at 0 and 0.01 um/mm more.
FitResult fit_reversal(double share, const char* form, FitJob& job_out) {
  const HiddenMachine hidden(
      three_axis_machine("tool"),
      fmt::format("[errors]\nEXX = {{ forward = {{ poly = [{0}, {1}] }}, backward = {{ "
                  "poly = [-{0}, -{1}] }} }}\n",
                  1.5 * share, 0.005 * share));
  const Instrument both_ways{0, 1, true, 1, 0};
  const Files files = {
      {"hidden.toml", hidden.text},
      {"x.csv", run_file(hidden, 0, 0, spaced_targets(-200, 300, 11), {}, Vec3::Zero(), both_ways)}};
  const auto job = read_job(fmt::format("format = 1\nmachine = \"hidden.toml\"\n[[run]]\nfile = "
                                        "\"x.csv\"\nerror = \"EXX\"\n[functions]\nEXX = {{ form = "
                                        "\"polynomial\", order = 2, reversal = \"{}\" }}\n",
                                        form),
                            files);
  job_out = *job.value;
  const auto observations = observations_of(*job.value);
  return fit_jointly(*job.value, *observations.value, *unknowns_of(*job.value, *observations.value).value);
}

TEST(StateGrids, ReversalIsTheMeanOfAllStates) {
  FitJob job;
  const auto lost_motion = [&](const std::string& errors, double x) {
    const auto machine =
        read_machine({"m.toml", three_axis_machine("tool")}, MachineText{"e.toml", errors}, {});
    const auto plan = std::get<Plan>(make_plan(machine.value.value(), {{"T1", 20}}));
    Query query;
    query.q[0] = x;
    query.tool = tool_of(*machine.value);
    query.approach[0] = 1;
    const double forward = actual_tip(plan, query)[0];
    query.approach[0] = -1;
    return forward - actual_tip(plan, query)[0];
  };
  constexpr double kSlack = 0.01 * um;
  const auto write = [&](const char* cold, const char* warm) {
    return write_state_grids(job, "T1", {{18, fit_reversal(1, cold, job)}, {24, fit_reversal(3, warm, job)}});
  };
  for (const char* other : {"table", "constant"}) {
    const StateGrids found = write("table", other);
    ASSERT_EQ(found.obstacle, "") << other;
    // Mean of both: 6 um and 0.02 um/mm, of which a constant shows the value in the middle of the travel.
    const double slope = std::string(other) == "table" ? 0.02 : 0.005, at_middle = 7 * um;
    for (const double x : {-200.0, -63.0, 150.0, 300.0})
      EXPECT_NEAR(lost_motion(found.text, x), at_middle + slope * (x - 50) * um, kSlack) << other << x;
  }
  EXPECT_NEAR(lost_motion(write("constant", "constant").text, 300), 7 * um, kSlack);
  EXPECT_NE(write("table", "none").obstacle, "");
  EXPECT_NE(write("none", "constant").obstacle, "");
}

TEST(StateGrids, StatesMustBeMeasuredAlike) {
  FitJob job;
  std::vector<ThermalState> states = {{18, fit_state(1, job)}, {24, fit_state(2, job)}};
  states[1].result.functions.clear();
  EXPECT_NE(write_state_grids(job, "T1", states).obstacle, "");
  std::swap(states[0], states[1]);
  EXPECT_NE(write_state_grids(job, "T1", states).obstacle, "");
}

}  // namespace
}  // namespace abbe
