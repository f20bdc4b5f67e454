// Location errors of rotary axes from balls on the table that a probe touches at several angles.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "abbe/fit/ball_plan.h"
#include "abbe/fit/test_hidden_machine.h"

namespace abbe {
namespace {

using namespace test;

constexpr const char* kFiveAxes = R"(format = 1
[machine]
name = "hidden"
chain = "w C A b X Y Z t"
[axis.C]
direction = [0, 0, 1]
errors_seen = "body"
[axis.A]
direction = [1, 0, 0]
errors_seen = "body"
[tool]
origin = [0, 0, 300]
length = 100
)";
constexpr const char* kHidden =
    "[errors]\nEC0Y = 12\nEX0C = 9\nEY0C = -7\nEA0C = 15\nEB0C = -25\nEY0A = 6\nEZ0A = -11\nEB0A = 18\nEC0A "
    "= -14\n";

using Pose = std::array<double, kMaxAxes>;  // C A X Y Z along the chain

/// The pose at which the true tip is at p_w: X, Y, Z by Newton steps with differences.
Pose touch(const HiddenMachine& hidden, const Vec3& p_w, double c, double a) {
  Pose q = {c, a, 0, 0, 0};
  for (int step = 0; step < 6; ++step) {
    const Vec3 tip = actual_tip(hidden.actual, hidden.query(q));
    Mat3 J;
    for (std::size_t k = 0; k < 3; ++k) {
      Pose moved = q;
      moved[2 + k] += 1;
      J.col(static_cast<Eigen::Index>(k)) = actual_tip(hidden.actual, hidden.query(moved)) - tip;
    }
    const Vec3 dq = J.partialPivLu().solve(p_w - tip);
    for (std::size_t k = 0; k < 3; ++k) q[2 + k] += dq[static_cast<Eigen::Index>(k)];
  }
  return q;
}

FitResult fit_balls(const HiddenMachine& hidden, const std::vector<Vec3>& balls,
                    std::string* errors = nullptr) {
  std::string csv = "C [deg],A [deg],X [mm],Y [mm],Z [mm],ball\n";
  for (std::size_t b = 0; b < balls.size(); ++b)
    for (const double a : {-60.0, -20.0, 0.0, 30.0, 70.0})
      for (const double c : {0.0, 70.0, 140.0, 220.0, 310.0}) {
        const Pose q = touch(hidden, balls[b], c * deg, a * deg);
        csv += fmt::format("{},{},{:.17g},{:.17g},{:.17g},{}\n", c, a, q[2], q[3], q[4], b + 1);
      }
  const Files files = {{"hidden.toml", hidden.text}, {"balls.csv", csv}};
  const Parsed<FitJob> job =
      read_job("format = 1\nmachine = \"hidden.toml\"\n[[ball]]\nfile = \"balls.csv\"\nnoise = 1\n", files);
  if (!job.value) throw std::runtime_error(codes(job.diagnostics));
  const Parsed<Observations> observations = observations_of(*job.value);
  const Parsed<Unknowns> unknowns = unknowns_of(*job.value, *observations.value);
  FitResult result = fit_jointly(*job.value, *observations.value, *unknowns.value);
  if (errors != nullptr) *errors = write_errors_file(*job.value, result);
  return result;
}

TEST(Balls, TellTheAxesOfATableApart) {
  const HiddenMachine hidden(kFiveAxes, kHidden);
  std::string errors;
  const FitResult result = fit_balls(hidden, {{100, 0, 50}, {-40, 80, 120}, {20, -90, 20}}, &errors);
  ASSERT_EQ(result.status, FitResult::Status::ok);
  EXPECT_LT(result.sets.front().max, 20 * nm);
  const Parsed<Machine> found =
      read_machine({"hidden.toml", hidden.text}, MachineText{"errors.toml", errors}, {});
  ASSERT_TRUE(found.value) << codes(found.diagnostics);
  // At poses and tips that were not touched, up to where the workpiece lies.
  std::vector<Pose> poses;
  for (const double c : {-100.0, 15.0, 190.0})
    for (const double a : {-80.0, 10.0, 50.0})
      for (const double x : {-150.0, 150.0})
        for (const double z : {-100.0, 60.0}) poses.push_back({c * deg, a * deg, x, 0.5 * x, z});
  EXPECT_LT(largest_difference(hidden, HiddenMachine::plan(*found.value), poses), 50 * nm) << errors;
  EXPECT_GT(largest_difference(hidden, hidden.ideal, poses), 5 * um);
}

TEST(Balls, WhatOneBallOnTheAxisDoesNotShowIsNamed) {
  const HiddenMachine hidden(kFiveAxes, kHidden);
  const FitResult many = fit_balls(hidden, {{100, 0, 50}, {-40, 80, 120}, {20, -90, 20}});
  const FitResult one = fit_balls(hidden, {{0, 0, 50}});
  EXPECT_GT(one.not_determined.size(), many.not_determined.size());
  for (const NotDetermined& missing : one.not_determined)
    EXPECT_TRUE(missing.like.empty() || !missing.like.front().empty()) << missing.name;
}

TEST(Balls, PosesThatHoldNoBallAreRefused) {
  const Files files = {
      {"hidden.toml", kFiveAxes},
      {"balls.csv", "C [deg],A [deg],X [mm],Y [mm],Z [mm],ball\n0,0,100,0,0,1\n90,0,100,0,0,1\n"}};
  const Parsed<FitJob> job =
      read_job("format = 1\nmachine = \"hidden.toml\"\n[[ball]]\nfile = \"balls.csv\"\n", files);
  ASSERT_TRUE(job.value) << codes(job.diagnostics);
  const Parsed<Observations> observations = observations_of(*job.value);
  ASSERT_FALSE(observations.value);
  EXPECT_EQ(observations.diagnostics.front().code, "E-JOB-BALL");
}

/// The file of an R-test: commands of the ideal machine, readings of the true one; `nest` on tool or work.
std::string rtest_file(const HiddenMachine& hidden, const std::vector<Vec3>& balls, bool on_work) {
  BallPlan plan;
  plan.places = balls;
  plan.angles[0] = {0, 70 * deg, 140 * deg, 220 * deg, 310 * deg};
  plan.angles[1] = {-60 * deg, -20 * deg, 0, 30 * deg, 70 * deg};
  const FitPoints points = std::get<FitPoints>(plan_balls(hidden.machine, plan));
  std::string csv = "C [deg],A [deg],X [mm],Y [mm],Z [mm],ball,x [um],y [um],z [um]\n";
  for (std::size_t i = 0; i < points.poses.size(); ++i) {
    const Pose& q = points.poses[i];
    const Query query = hidden.query(q);
    const Vec3 place = balls[static_cast<std::size_t>(points.ball[i] - 1)] + Vec3(0.02, -0.03, 0.01);
    Vec3 seen = actual_tip(hidden.actual, query) - place;
    EXPECT_LT((nominal_tip(hidden.ideal, query) - balls[static_cast<std::size_t>(points.ball[i] - 1)]).norm(),
              1e-9);
    if (!on_work) seen = nominal_pose(hidden.ideal, query).R.transpose() * seen;
    csv +=
        fmt::format("{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{},{:.17g},{:.17g},{:.17g}\n", q[0] / deg,
                    q[1] / deg, q[2], q[3], q[4], points.ball[i], seen[0] / um, seen[1] / um, seen[2] / um);
  }
  return csv;
}

FitResult fit_rtest(const HiddenMachine& hidden, const std::vector<Vec3>& balls, bool on_work,
                    const char* more = "") {
  const Files files = {{"hidden.toml", hidden.text}, {"balls.csv", rtest_file(hidden, balls, on_work)}};
  const Parsed<FitJob> job = read_job(
      fmt::format(
          "format = 1\nmachine = \"hidden.toml\"\nlocations = [\"EX0C\", \"EY0C\", \"EA0C\", \"EB0C\", "
          "\"EY0A\", \"EZ0A\", \"EB0A\", \"EC0A\"]\n[[ball]]\nfile = \"balls.csv\"\nnoise = 1\nnest = "
          "\"{}\"\n{}",
          on_work ? "work" : "tool", more),
      files);
  if (!job.value) throw std::runtime_error(codes(job.diagnostics));
  const Parsed<Observations> observations = observations_of(*job.value);
  return fit_jointly(*job.value, *observations.value, *unknowns_of(*job.value, *observations.value).value);
}

constexpr const char* kEightOnly =
    "[errors]\nEX0C = 9\nEY0C = -7\nEA0C = 15\nEB0C = -25\nEY0A = 6\nEZ0A = -11\nEB0A = 18\nEC0A = -14\n";

double found_value(const FitResult& result, const std::string& name) {
  for (const FoundValue& value : result.locations)
    if (value.name == name) return value.value;
  return std::numeric_limits<double>::quiet_NaN();
}

TEST(RTest, AllEightLocationErrorsOfATableAreFound) {
  const HiddenMachine hidden(kFiveAxes, kEightOnly);
  for (const bool on_work : {false, true}) {
    const FitResult result = fit_rtest(hidden, {{100, 0, 50}, {-40, 80, 120}, {20, -90, 20}}, on_work);
    EXPECT_TRUE(result.not_determined.empty());
    EXPECT_EQ(result.locations.size(), 8U);
    const std::pair<const char*, double> truth[] = {{"EX0C", 9}, {"EY0C", -7},  {"EA0C", 15}, {"EB0C", -25},
                                                    {"EY0A", 6}, {"EZ0A", -11}, {"EB0A", 18}, {"EC0A", -14}};
    for (const auto& [name, value] : truth) EXPECT_NEAR(found_value(result, name), value, 0.02) << name;
  }
}

TEST(RTest, ABallOnTheAxisLeavesTiltAndPlaceTogether) {
  // Only C turns, the ball on its axis at height h: the axis displaced by h times its tilt looks the same. A
  // ball beside the axis shows the tilt by its way up and down, at one height already.
  const HiddenMachine hidden(kFiveAxes, kEightOnly);
  const auto fit_c = [&](const std::vector<Vec3>& balls) {
    std::string csv = "C [deg],A [deg],X [mm],Y [mm],Z [mm],ball\n";
    for (std::size_t b = 0; b < balls.size(); ++b)
      for (const double c : {0.0, 60.0, 130.0, 200.0, 290.0}) {
        const Pose q = touch(hidden, balls[b], c * deg, 0);
        csv += fmt::format("{},0,{:.17g},{:.17g},{:.17g},{}\n", c, q[2], q[3], q[4], b + 1);
      }
    const Files files = {{"hidden.toml", hidden.text}, {"balls.csv", csv}};
    const auto job = read_job(
        "format = 1\nmachine = \"hidden.toml\"\nlocations = [\"EX0C\", \"EY0C\", \"EA0C\", "
        "\"EB0C\"]\n[[ball]]\nfile "
        "= \"balls.csv\"\nnoise = 1\n",
        files);
    const auto observations = observations_of(*job.value);
    return fit_jointly(*job.value, *observations.value, *unknowns_of(*job.value, *observations.value).value);
  };
  EXPECT_TRUE(fit_c({{100, 0, 50}, {60, 10, 150}}).not_determined.empty());
  EXPECT_TRUE(fit_c({{100, 0, 50}}).not_determined.empty());
  const FitResult one = fit_c({{0, 0, 50}});
  ASSERT_EQ(one.not_determined.size(), 2U);
  EXPECT_EQ(one.not_determined[0].name, "EA0C");
  EXPECT_THAT(one.not_determined[0].like, ::testing::Contains("EY0C"));
  EXPECT_EQ(one.not_determined[1].name, "EB0C");
  EXPECT_THAT(one.not_determined[1].like, ::testing::Contains("EX0C"));
  for (const NotDetermined& missing : one.not_determined) EXPECT_TRUE(missing.asked) << missing.name;
}

TEST(RTest, ReadingsThatDoNotFitAreRefused) {
  const HiddenMachine hidden(kFiveAxes, kEightOnly);
  const auto code_of = [&](const std::string& csv, const std::string& keys) {
    const auto job = read_job("format = 1\nmachine = \"hidden.toml\"\n[[ball]]\nfile = \"b.csv\"\n" + keys,
                              {{"hidden.toml", hidden.text}, {"b.csv", csv}});
    return job.value ? std::string("read") : job.diagnostics.front().code;
  };
  const std::string axes = "C [deg],A [deg],X [mm],Y [mm],Z [mm],ball";
  EXPECT_EQ(code_of(axes + "\n0,0,1,2,3,1\n", ""), "read");
  EXPECT_EQ(code_of(axes + ",x [um],y [um]\n0,0,1,2,3,1,5,5\n", ""), "E-JOB-KIND");
  EXPECT_EQ(code_of(axes + ",x [urad],y [um],z [um]\n0,0,1,2,3,1,5,5,5\n", ""), "E-JOB-KIND");
  EXPECT_EQ(code_of(axes + "\n0,0,1,2,nan,1\n", ""), "E-MEASURED-CELL");
  EXPECT_EQ(code_of(axes + "\n0,0,1,2,3,1\n", "nest = \"moon\"\n"), "E-VALUE");
}

}  // namespace
}  // namespace abbe
