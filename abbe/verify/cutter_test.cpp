// Cutter radius compensation: the verifying reader stands where the cutter's centre is.
#include <gtest/gtest.h>

#include <numbers>

#include "abbe/verify/test_programs.h"

namespace abbe::verifying {
namespace {

std::string contour(const Pen& p) {
  return "G0" + p.at(-40, -10, 0) + "\nG41 D1 G1 F100" + p.at(-10, 0, 0) + "\nG1" + p.at(20, 0, 0) + "\nG3" +
         p.at(30, 10, 0) + p.centre(20, 0, 0, 20, 10) + "\nG1" + p.at(30, 30, 0) + "\nG1 Z" +
         p.number(p.command(30, 30, -2).z()) + "\nG1" + p.at(-10, 30, -2) + "\nG40 G1" + p.at(-40, 40, -2) +
         "\nG0" + p.at(-40, 40, 5) + "\nM2\n";
}

VerifyJob with_radius(double radius) {
  VerifyJob job = ideal_job();
  job.setup.radii[1] = radius;
  job.setup.radii[2] = radius + 1;
  return job;
}

TEST(CutterCompensation, ACorrectedContourAgrees) {
  for (const double radius : {0.0, 5.0}) {
    const VerifyReport report = verify_drawn(contour, with_radius(radius));
    EXPECT_TRUE(report.agrees) << radius << "\n" << texts(report);
    // beside the way along Y: 1e-4 * 5 mm are left at the centre
    // and the bow of 0.4 um of the block to X-10
    EXPECT_NEAR(report.after.max, std::max(0.4e-3, 0.1e-3 * radius), 0.1e-3);
    EXPECT_EQ(report.feed_motions, 7U);
  }
}

struct Wrong {
  const char *name, *from, *to, *code;
};
void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }

class WrongContour : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongContour, IsFound) {
  std::string output = contour(Pen(true));
  const std::size_t at = output.find(GetParam().from);
  ASSERT_NE(at, std::string::npos) << output;
  output.replace(at, std::string(GetParam().from).size(), GetParam().to);
  const VerifyReport report = verify(plan_of(kMachine), contour(Pen(false)), output, with_radius(5));
  ASSERT_FALSE(report.agrees) << output;
  EXPECT_EQ(report.diagnostics.front().code, GetParam().code) << texts(report);
}

INSTANTIATE_TEST_SUITE_P(
    All, WrongContour,
    ::testing::Values(Wrong{"OtherSide", "G41", "G42", "V-EVENT"},
                      Wrong{"OtherRadius", "D1", "D2", "V-EVENT"},
                      Wrong{"NeverSwitchedOn", "G41 D1 ", "", "V-EVENT"},
                      Wrong{"NeverSwitchedOff", "G40 ", "", "V-EVENT"},
                      Wrong{"SwitchedOffTooEarly", "\nG3", "\nG40 G3", "E-CUTCOM"},
                      Wrong{"AWordBesideTheMotionAcross", "G1 Z-2.0070", "G1 X29.9971 Z-2.0070", "V-CUTTER"},
                      Wrong{"ASplitBeginning", "G41 D1 G1 F100 X", "G41 D1 G1 F100 X-25. Y-5.\nX", "V-END"},
                      Wrong{"AnUncorrectedContour", "Y29.9991", "Y30.0021", "V-END"}),
    [](const auto& test) { return std::string(test.param.name); });

/// Pieces at an inside corner that are shorter than r tan(theta / 2) leave the control without its corner.
TEST(CutterCompensation, AShortPieceAtAnInsideCornerIsFound) {
  const auto program = [](const char* pieces) {
    return std::string("G0 X0 Y-40 Z5\nG41 D1 G1 Y0 F100\n") + pieces + "G1 Y30\nG40 Y60\nM2\n";
  };
  const Plan plan = plan_of(kPerfect);
  const std::string original = program("G1 X30\n");
  EXPECT_TRUE(verify(plan, original, program("G1 X24\nX30\n"), with_radius(5)).agrees);
  const VerifyReport report = verify(plan, original, program("G1 X26\nX30\n"), with_radius(5));
  ASSERT_FALSE(report.agrees);
  EXPECT_EQ(report.diagnostics.front().code, "V-CUTTER") << texts(report);
  EXPECT_TRUE(verify(plan, original, program("G1 X26\nX30\n"), with_radius(3)).agrees);
}

TEST(CutterCompensation, AnArcAroundTheCutterMustBeLarger) {
  const VerifyReport report = verify_drawn(contour, with_radius(11));
  ASSERT_FALSE(report.agrees);
  EXPECT_EQ(report.diagnostics.front().code, "V-CUTTER") << texts(report);
}

/// X errs by 1e-5 x^2: at x = 10 a centre on the left stands at x = 5 and lacks 0.75 um of the correction,
/// one on the right at x = 15 has 1.25 um too much.
constexpr const char* kBentX = R"(format = 1
[machine]
name = "bent"
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
[errors]
EXX = { poly = [0, 0, 0.01] }
)";

TEST(CutterCompensation, TheErrorIsTakenAtTheCentreOfItsSide) {
  const auto program = [](const char* code, const char* x) {
    return std::string("G0 X") + x + " Y-30 Z5\n" + code + " D1\nG1 Y-10 F100\nY10\nG40 Y30\nM2\n";
  };
  const Plan plan = plan_of(kBentX);
  const auto judged = [&](const char* code, double radius) {
    return verify(plan, program(code, "10"), program(code, "9.999"), with_radius(radius));
  };
  EXPECT_TRUE(judged("G41", 5).agrees) << texts(judged("G41", 5));
  EXPECT_NEAR(judged("G41", 5).after.max, 0.75e-3, 1e-5);
  const VerifyReport right = judged("G42", 5);
  ASSERT_FALSE(right.agrees);
  EXPECT_EQ(right.diagnostics.front().code, "V-PATH") << texts(right);
  EXPECT_TRUE(judged("G42", 3).agrees) << texts(judged("G42", 3));
}

TEST(CutterCompensation, TheSideTurnsWithTheWorkOffset) {
  // Rz(90 degrees) (x, -10) = (10, x)
  const auto program = [](const char* code, const char* y) {
    return std::string("G0 X-30 Y") + y + " Z5\n" + code + " D1\nG1 X-10 F100\nX10\nG40 X30\nM2\n";
  };
  VerifyJob job = with_radius(5);
  job.setup.work_offsets[0] = WorkOffset{{}, std::numbers::pi / 2};
  const Plan plan = plan_of(kBentX);
  EXPECT_TRUE(verify(plan, program("G41", "-10"), program("G41", "-9.999"), job).agrees);
  EXPECT_FALSE(verify(plan, program("G42", "-10"), program("G42", "-9.999"), job).agrees);
}

struct Under {
  const char* block;
};
void PrintTo(const Under& under, std::ostream* out) { *out << under.block; }

class UnderCompensation : public ::testing::TestWithParam<Under> {};

TEST_P(UnderCompensation, IsRefused) {
  const std::string program =
      std::string("G0 X0 Y-40 Z5\nG41 D1 G1 Y0 F100\nG1 Y30\n") + GetParam().block + "\nG40 G1 Y90\nM2\n";
  VerifyJob job = with_radius(5);
  job.setup.tool_change_keeps_place = true;
  const VerifyReport report = verify(plan_of(kPerfect), program, program, job);
  ASSERT_FALSE(report.agrees);
  EXPECT_EQ(report.diagnostics.front().code, "E-CUTCOM") << texts(report);
}

INSTANTIATE_TEST_SUITE_P(Blocks, UnderCompensation,
                         ::testing::Values(Under{"G53 G0 Z0"}, Under{"G28 Z5"}, Under{"G92 X0"}, Under{"G55"},
                                           Under{"G18"}, Under{"G20"}, Under{"G43.1 Z5"}, Under{"T1 M6"},
                                           Under{"G81 X9 Z-5 R1"}, Under{"M2"}, Under{"M30"}, Under{"G42 D1"},
                                           Under{"G41 D1"}, Under{"G3 X0 Y30 I-20 J0 P2"}));

}  // namespace
}  // namespace abbe::verifying
