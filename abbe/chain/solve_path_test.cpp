#include "abbe/chain/solve_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "abbe/chain/predict.h"
#include "abbe/chain/test_grinder.h"
#include "abbe/chain/test_random_machine.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

Machine machine_of(const std::string& text) {
  return read_machine({"test.toml", text}, std::nullopt,
                      [](const std::string&) { return std::optional<std::string>(); })
      .value.value_or(Machine{});
}

Plan plan_of(const Machine& machine) { return std::get<Plan>(make_plan(machine, {{"T1", 20}})); }

std::size_t index(const Machine& machine, const char* name) {
  return static_cast<std::size_t>(machine.find_axis(name));
}

PathOptions options_for(const Machine& machine) {
  PathOptions options;
  options.free = *free_axes(machine, 0);
  return options;
}

TEST(PathSolver, OnePathKeepsItsBranch) {
  // A cone of 30 deg about z, coarse: 100 deg of C per point. The other branch (A negative) would be nearer
  // in C, but no way leads there.
  const Machine machine = machine_of(grinder::text(0));
  const Plan plan = plan_of(machine);
  std::array<double, kMaxAxes> start{};
  start[index(machine, "A")] = 0.5;
  PathSolver path(options_for(machine), start);
  double last = 0;
  for (int i = 0; i < 30; ++i) {
    SCOPED_TRACE(i);
    const double around = i * 100 * deg, tilt = 30 * deg;
    const Vec3 axis(std::sin(tilt) * std::cos(around), std::sin(tilt) * std::sin(around), std::cos(tilt));
    const InverseResult r = path.pose(plan, tool_of(machine), Vec3(20, -30, 40), axis);
    ASSERT_EQ(r.status, Status::ok);
    EXPECT_GT(r.q[index(machine, "A")], 0);
    EXPECT_FALSE(path.branch_changed());
    if (i > 0) {
      EXPECT_NEAR(std::abs(r.q[index(machine, "C")] - last), 100 * deg, 1e-3);
    }
    last = r.q[index(machine, "C")];
  }
  EXPECT_EQ(path.report().points, 30U);
  EXPECT_EQ(path.report().branch_changes, 0U);
  EXPECT_NEAR(path.report().largest_step[index(machine, "C")], 100 * deg, 1e-3);
  // Unwrapped: C went on in one direction.
  EXPECT_NEAR(std::abs(last), 29 * 100 * deg, kTurn);
}

TEST(PathSolver, ThroughTheSingularConeItTakesTheShortWay) {
  // The tool swings through the axis of C: A goes on to the other sign, C stays.
  const Machine machine = machine_of(grinder::kText);
  const Plan plan = plan_of(machine);
  std::array<double, kMaxAxes> start{};
  start[index(machine, "A")] = 0.1;
  PathSolver path(options_for(machine), start);
  for (int i = 0; i <= 20; ++i) {
    const double tilt = (10 - i) * 0.01;
    const InverseResult r =
        path.pose(plan, tool_of(machine), Vec3(20, -30, 40), Vec3(0, -std::sin(tilt), std::cos(tilt)));
    ASSERT_EQ(r.status, Status::ok);
    EXPECT_NEAR(r.q[index(machine, "A")], tilt, 1e-12) << i;
    EXPECT_NEAR(r.q[index(machine, "C")], 0, 1e-9) << i;
  }
  EXPECT_EQ(path.report().branch_changes, 1U);
  EXPECT_LE(path.report().largest_step[index(machine, "C")], 1e-9);
}

TEST(PathSolver, TravelsMayForceTheOtherBranchAndItIsSaid) {
  std::string text = grinder::kText;
  text.replace(text.find("[axis.A]"), 8, "[axis.A]\nrange = [-2, 0.35]");
  const Machine machine = machine_of(text);
  const Plan plan = plan_of(machine);
  std::array<double, kMaxAxes> start{};
  start[index(machine, "A")] = 0.3;
  PathSolver path(options_for(machine), start);
  std::uint64_t changed_at = 0;
  for (int i = 0; i < 10; ++i) {
    const double tilt = 0.3 + 0.01 * i;
    const InverseResult r =
        path.pose(plan, tool_of(machine), Vec3(20, -30, 40), Vec3(0, -std::sin(tilt), std::cos(tilt)));
    ASSERT_EQ(r.status, Status::ok);
    if (path.branch_changed()) changed_at = static_cast<std::uint64_t>(i) + 1;
  }
  EXPECT_EQ(changed_at, 7U);
  EXPECT_EQ(path.report().branch_changes, 1U);
  EXPECT_NEAR(path.report().largest_step[index(machine, "C")], 180 * deg, 1e-9);
  EXPECT_EQ(path.report().largest_at[index(machine, "C")], changed_at);
}

TEST(PathSolver, UnwrappedStepsAreSmall) {
  // Commands as a post-processor writes them, C wrapped to half a turn: the corrected ones go on.
  const Machine machine = machine_of(grinder::text(0));
  const Plan plan = plan_of(machine);
  PathSolver path(options_for(machine), {});
  const auto c = index(machine, "C");
  for (int i = 0; i < 100; ++i) {
    Query query;
    query.tool = tool_of(machine);
    query.q[index(machine, "A")] = 0.5;
    query.q[c] = std::remainder(i * 20 * deg, kTurn);
    const double wrapped = query.q[c];
    const Correction r = path.command(plan, query);
    ASSERT_EQ(r.status, Status::ok);
    EXPECT_NEAR(query.q[c], i * 20 * deg, 1e-12);
    EXPECT_NEAR(r.corrected[c], i * 20 * deg, 1e-3);
    EXPECT_NEAR(std::remainder(query.q[c] - wrapped, kTurn), 0, 1e-12);
  }
  EXPECT_NEAR(path.report().largest_step[c], 20 * deg, 1e-4);

  // Not beyond the travel.
  std::string text = grinder::text(0);
  text.replace(text.find("[axis.C]"), 8, "[axis.C]\nrange = [-3.2, 3.2]");
  const Machine limited = machine_of(text);
  PathSolver ends(options_for(limited), {});
  for (const double angle : {170.0, -170.0}) {
    Query query;
    query.tool = tool_of(limited);
    query.q[index(limited, "A")] = 0.5;
    query.q[c] = angle * deg;
    static_cast<void>(ends.command(plan_of(limited), query));
    EXPECT_EQ(query.q[c], angle * deg);
  }
  EXPECT_NEAR(ends.report().largest_step[c], 340 * deg, 1e-4);
}

TEST(PathSolver, PointsOfAPathEqualSinglePoints) {
  RandomMachine random(31);
  for (int i = 0; i < 30; ++i) {
    SCOPED_TRACE(i);
    const Machine machine = random.make(3, 2, 0.02, 5e-5);
    const Plan plan = plan_of(machine);
    const AxisSet free = *free_axes(machine, 0);
    Query from = random.query(machine, 200, 1);
    const Query to = random.query(machine, 200, 1);
    from.approach = {};  // poses know no direction of approach
    PathSolver commands(options_for(machine), from.q), poses(options_for(machine), from.q);
    std::array<double, kMaxAxes> largest{}, last{};
    for (int k = 0; k <= 20; ++k) {
      Query query = from;
      for (std::size_t a = 0; a < 5; ++a) query.q[a] += (to.q[a] - from.q[a]) * k / 20;
      Query same = query;
      const Correction alone = correct(plan, query, free, {}), c = commands.command(plan, same);
      EXPECT_EQ(same.q, query.q);
      EXPECT_EQ(c.status, alone.status);
      for (std::size_t a = 0; a < 5 && k > 0; ++a)
        largest[a] = std::max(largest[a], std::abs(c.corrected[a] - last[a]));
      last = c.corrected;
      if (c.status != Status::ok) continue;
      const Pose nominal = nominal_pose(plan, query);
      Query there = query;
      there.q = c.corrected;
      EXPECT_LE((actual_pose(plan, there).p - nominal.p).norm(), 1e-9);
      const InverseResult p = poses.pose(plan, query.tool, nominal.p, nominal.R * query.tool.axis);
      there.q = p.q;
      if (p.status == Status::ok) {
        EXPECT_LE((actual_pose(plan, there).p - nominal.p).norm(), 1e-8);
      }
    }
    if (commands.report().points != 21) continue;
    for (std::size_t a = 0; a < 5; ++a) EXPECT_EQ(commands.report().largest_step[a], largest[a]);
  }
}

TEST(PathSolver, PointsWithoutAnAnswerAreLeftOut) {
  const Machine machine = machine_of(grinder::text(0));
  const Plan plan = plan_of(machine);
  PathSolver path(options_for(machine), {});
  const Tool tool = tool_of(machine);
  static_cast<void>(path.pose(plan, tool, Vec3(0, 0, 0), Vec3(0, -0.5, 1)));
  EXPECT_EQ(path.pose(plan, tool, Vec3(0, 0, 0), Vec3::Zero()).status, Status::failed);
  static_cast<void>(path.pose(plan, tool, Vec3(10, 0, 0), Vec3(0, -0.5, 1)));
  EXPECT_EQ(path.report().points, 2U);
  EXPECT_EQ(path.report().largest_at[index(machine, "X")], 3U);
  EXPECT_NEAR(path.report().largest_step[index(machine, "X")], 10, 0.1);
}

}  // namespace
}  // namespace abbe
