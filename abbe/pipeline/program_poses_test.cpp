#include "abbe/pipeline/program_poses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "abbe/core/test_files.h"
#include "abbe/machine/read_machine.h"
#include "abbe/machine/read_profile.h"

namespace abbe {
namespace {

constexpr double kPico = 1e-9;  // mm

const std::string kHead = R"(format = 1
[machine]
name = "mill"
chain = "w X b Y Z t"
[axis.X]
errors_seen = "tool"
[axis.Y]
[axis.Z]
[tool]
origin = [0, 0, 300]
length = 100
)";

const std::string kFiveAxes = R"(format = 1
[machine]
name = "five"
chain = "w C A b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
[axis.A]
direction = [1, 0, 0]
origin = [0, 0, 40]
[axis.C]
direction = [0, 0, 1]
origin = [0, 0, 40]
[tool]
origin = [0, 0, 300]
length = 100
[control]
mode = "axis"
)";

Machine machine_of(const std::string& text) {
  auto machine =
      read_machine({"m.toml", text}, std::nullopt, [](const std::string&) { return std::nullopt; });
  EXPECT_TRUE(machine.value);
  return *machine.value;
}

struct Followed {
  PoseReport report;
  std::vector<MotionPoses> motions;
};

Followed follow(const std::string& machine_text, const std::string& program,
                DatumRule datum = DatumRule::ideal, bool clock = false,
                const std::string& dialect = "linuxcnc") {
  const testing::TestFile file(program);
  const Machine machine = machine_of(machine_text);
  const auto plan_of = [&](double t) { return std::get<Plan>(make_plan(machine, {{"t", t}})); };
  PoseJob job;
  job.path = job.name = file.path();
  job.datum = datum;
  job.setup.work_offsets[0] = WorkOffset{{30, -20, -250}, 0, {}};
  job.setup.loaded_tool = 0;
  job.setup.profile = embedded_profile(dialect);
  job.setup.start = {0, 0, 0};
  if (clock) job.plan_at = [&](double t) { return std::optional(plan_of(t)); };
  Followed out;
  out.report = program_poses(plan_of(0), job, [&](const MotionPoses& m) { out.motions.push_back(m); });
  for (const Diagnostic& d : out.report.diagnostics) ADD_FAILURE_AT(__FILE__, __LINE__) << to_text(d);
  return out;
}

const std::string kSquare = "G21 G90 G54 G94\nG0 X0 Y0 Z5\nG1 Z-2 F600\nG1 X40\nG1 Y30\nG0 Z5\nM2\n";

TEST(ProgramPoses, APerfectMachineIsWhereTheProgramSays) {
  const Followed is = follow(kHead, kSquare + "");
  ASSERT_EQ(is.motions.size(), 4u) << "the rapid before the first feed has no part yet";
  EXPECT_EQ(is.report.end, PoseReport::End::done);
  EXPECT_LT((is.motions[1].poses.front().tip - Vec3(0, 0, -2)).norm(), kPico);
  EXPECT_LT((is.motions[1].poses.back().tip - Vec3(40, 0, -2)).norm(), kPico);
  EXPECT_LT((is.motions[2].poses.back().tip - Vec3(40, 30, -2)).norm(), kPico);
  EXPECT_LT((is.motions[2].poses.back().axis - Vec3::UnitZ()).norm(), 1e-15);
  EXPECT_TRUE(is.motions[3].rapid);
  EXPECT_EQ(is.motions[2].line, 5u);
  EXPECT_NEAR(is.report.feed_length, 77, kPico);
  EXPECT_NEAR(is.report.seconds, 7.7 + 7 / 10000.0 * 60, kPico);
}

// F100 of a conversational program in inches is 10 inch/min.
TEST(ProgramPoses, ConversationalFeedsInInchesAreTenths) {
  const Followed is = follow(kHead,
                             "0 BEGIN PGM A INCH\n1 L X+0 Y+0 Z+1 R0 FMAX\n2 L Z+0 F100\n3 L X+4\n"
                             "4 END PGM A INCH\n",
                             DatumRule::ideal, false, "heidenhain");
  EXPECT_NEAR(is.report.feed_length, 127, kPico);
  EXPECT_NEAR(is.report.seconds, 30, 1e-9);
}

TEST(ProgramPoses, SquarenessShears) {
  // EC0Y = 100 urad: Y leans towards -X, x = -100e-6 y; ISO 230-1, a positive rotation about Z.
  const Followed is = follow(kHead + "[errors]\nEC0Y = 100\n", kSquare);
  const Vec3 end = is.motions[2].poses.back().tip, start = is.motions[2].poses.front().tip;
  EXPECT_NEAR((end - start).x(), -100e-6 * 30, 1e-9);
  EXPECT_NEAR((end - start).y(), 30, 1e-6);
}

TEST(ProgramPoses, ProbedDatumIsTakenOff) {
  const std::string bowed = kHead + "[errors]\nEZX = { poly = [7, 0, 0.001] }\n";
  const Followed ideal = follow(bowed, kSquare), probed = follow(bowed, kSquare, DatumRule::probed);
  // At X = 30 + x: 7 um + 0.001 um (30 + x)^2; the datum is that of x = 0.
  EXPECT_NEAR(ideal.motions[1].poses.back().tip.z() + 2, (7 + 0.001 * 4900) * um, kPico);
  EXPECT_NEAR(probed.motions[1].poses.back().tip.z() + 2, 0.001 * (4900 - 900) * um, kPico);
  EXPECT_NEAR(probed.report.datum.z(), 7.9 * um, kPico);
}

TEST(ProgramPoses, PosesFollowABentPath) {
  const Followed is = follow(kHead + "[errors]\nEZX = { sine = [20, 0.3, 0] }\n", kSquare);
  const MotionPoses& cut = is.motions[1];
  EXPECT_GT(cut.poses.size(), 30u);
  for (std::size_t k = 1; k < cut.poses.size(); ++k) {
    const Vec3 middle = (cut.poses[k].tip + cut.poses[k - 1].tip) / 2;
    EXPECT_NEAR(middle.z() + 2, 20 * um * std::sin(0.3 * (30 + middle.x())), 0.02 * um);
  }
}

TEST(ProgramPoses, ArcsAndHolesAreFollowed) {
  const Followed arc =
      follow(kHead, "G21 G90 G54 G94 G17\nG0 X10 Y0 Z0\nG1 Z-1 F300\nG3 X0 Y10 I-10 J0\nG0 Z9\nM2\n");
  for (const ToolPose& pose : arc.motions[1].poses)
    EXPECT_NEAR(std::hypot(pose.tip.x(), pose.tip.y()), 10, kPico);
  EXPECT_LT((arc.motions[1].poses.back().tip - Vec3(0, 10, -1)).norm(), kPico);
  const Followed holes =
      follow(kHead, "G21 G90 G54 G94\nG0 X0 Y0 Z9\nG1 Z8 F300\nG81 X10 Z-4 R2\nX20\nG80\nM2\n");
  double lowest = 0;
  for (const MotionPoses& m : holes.motions) lowest = std::min(lowest, m.poses.back().tip.z());
  EXPECT_NEAR(lowest, -4, kPico);
  EXPECT_NEAR(holes.motions.back().poses.back().tip.x(), 20, kPico);
}

TEST(ProgramPoses, DriftGrowsWithTime) {
  const std::string drifting = kHead + "[errors]\nTZZ = { poly = [0, 0.5], of = \"t\" }\n";
  std::string program = "G21 G90 G54 G94\nG0 X0 Y0 Z0\nG1 Z-1 F600\n";
  for (int k = 0; k < 10; ++k) program += k % 2 == 0 ? "G1 X100\n" : "G1 X0\n";
  const Followed is = follow(drifting, program + "M2\n", DatumRule::probed, true);
  // 10 s per pass, 0.5 um per s; a motion has the plan of its start, renewed every 10 s.
  for (std::size_t k = 1; k < is.motions.size(); ++k) {
    const double z = is.motions[k].poses.back().tip.z() + 1;
    EXPECT_NEAR(z, 0.5 * um * is.motions[k].time, (10 + 10.1) * 0.5 * um) << k;
    const double before = is.motions[k - 1].poses.back().tip.z() + 1;
    EXPECT_TRUE(k == 1 || z > before) << k;
  }
}

TEST(ProgramPoses, RotaryAxesTurnTheTool) {
  const Followed is = follow(kFiveAxes, "G21 G90 G54 G94\nG0 X0 Y0 Z0 A0 C0\nG1 Z-1 F300\nG1 A30\nM2\n");
  const MotionPoses& turn = is.motions.back();
  // The table leans by A: in the part the tool leans the other way.
  EXPECT_NEAR(turn.poses.back().axis.y(), std::sin(30 * deg), 1e-12);
  EXPECT_NEAR(turn.poses.back().axis.z(), std::cos(30 * deg), 1e-12);
  EXPECT_GE(turn.poses.size(), 120u);
}

std::string code_of(const std::string& program) {
  const testing::TestFile file(program);
  PoseJob job;
  job.path = job.name = file.path();
  job.setup.work_offsets[0] = WorkOffset{{30, -20, -250}, 0, {}};
  job.setup.start = {0, 0, 0};
  job.setup.tool_change_keeps_place = true;
  const Plan plan = std::get<Plan>(make_plan(machine_of(kHead), {}));
  const PoseReport report = program_poses(plan, job, [](const MotionPoses&) {});
  EXPECT_NE(report.end, PoseReport::End::done);
  return report.diagnostics.empty() ? "" : report.diagnostics.front().code;
}

TEST(ProgramPoses, WhatIsNotSureIsNamed) {
  EXPECT_EQ(code_of("G21 G90 G54\nG0 X0 Y0 Z0\n/G1 Z-1 F300\nM2\n"), "E-PART-SKIP");
  EXPECT_EQ(code_of("G21 G90 G54\nG0 X0 Y0 Z0\nG1 Q5\nM2\n").substr(0, 2), "E-");
}

}  // namespace
}  // namespace abbe
