// Location errors of rotary axes from balls on the table that a probe touches at several angles.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

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

}  // namespace
}  // namespace abbe
