#include "abbe/compensate/cutter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "abbe/compensate/rewrite_fixture.h"

namespace abbe {
namespace {

using testing::plain_job;
using testing::poly;
using testing::rewrite;
using testing::Rewritten;
using testing::three_axes;

constexpr double kRounding = 1e-12;

PlaneWay line(double x0, double y0, double x1, double y1) {
  return straight_way(Vec3(x0, y0, 0), Vec3(x1, y1, 7)).value_or(PlaneWay{});
}

TEST(CutOff, ARightAngleCutsOffTheRadius) {
  const PlaneWay east = line(0, 0, 20, 0), north = line(20, 0, 20, 6), back = line(20, 0, 0, 1e-9);
  EXPECT_NEAR(cut_off(east, north, 5), 5, kRounding);
  // theta = 60 degrees: 5 tan(30 degrees)
  EXPECT_NEAR(cut_off(east, line(20, 0, 25, 5 * std::sqrt(3)), 5), 5 / std::sqrt(3), kRounding);
  EXPECT_TRUE(corner_fits(east, north, 5));
  EXPECT_FALSE(corner_fits(east, line(20, 0, 20, 5.2), 5)) << "5.25 mm with the spare";
  EXPECT_FALSE(corner_fits(line(15, 0, 20, 0), north, 5)) << "the block before counts as well";
  EXPECT_GT(cut_off(east, back, 5), 1e6);
  EXPECT_GT(cut_off(east, line(20, 0, 0, 0), 5), 1e6) << "a turn back has no inner side";
  EXPECT_GT(cut_off(east, line(20, 0, 0, 0), -5), 1e6);
}

TEST(CutOff, ACornerAwayFromTheCutterCutsNothingOff) {
  EXPECT_EQ(cut_off(line(0, 0, 20, 0), line(20, 0, 20, -1), 5), 0);
  EXPECT_EQ(cut_off(line(0, 0, 20, 0), line(20, 0, 30, 0), 5), 0);
}

TEST(CutOff, MirroredPathsAreMirrored) {
  EXPECT_NEAR(cut_off(line(0, 0, 20, 0), line(20, 0, 20, -9), -5), 5, kRounding);
  EXPECT_EQ(cut_off(line(0, 0, 20, 0), line(20, 0, 20, 9), -5), 0);
}

TEST(CutOff, AnArcAroundTheCutterCutsOffMore) {
  // counter-clockwise about (0, 20) from (0, 0): leaves to the east, and the cutter is inside with G41
  const auto arc = arc_way(Vec3(0, 0, 0), Vec3(20, 20, 0), Centre{0, 20}, false);
  ASSERT_TRUE(arc);
  EXPECT_NEAR((arc->first - Vec3::UnitX()).norm(), 0, kRounding);
  EXPECT_NEAR((arc->last - Vec3::UnitY()).norm(), 0, kRounding);
  EXPECT_NEAR(arc->radius, 20, kRounding);
  // coming down from the north: turns left by 90 degrees; R / (R - r) = 20 / 15
  EXPECT_NEAR(cut_off(line(0, 9, 0, 0), *arc, 5), 5 * 20.0 / 15, 1e-9);
  EXPECT_TRUE(too_narrow(*arc, 20));
  EXPECT_FALSE(too_narrow(*arc, 19.9));
  EXPECT_FALSE(too_narrow(*arc, -25)) << "the cutter is outside";
}

TEST(ToCentre, LeftIsPositive) {
  EXPECT_EQ(to_centre(Vec3(3, 0, 9), 5), Vec3(0, 5, 0));
  EXPECT_EQ(to_centre(Vec3(0, 2, 0), -5), Vec3(5, 0, 0));
  EXPECT_EQ(to_centre(Vec3(0, 0, 2), 5), Vec3(0, 0, 0));
}

/// X is 1e-4 too long: x + 1e-4 x = what is meant.
Machine long_x() { return three_axes({{"EXX", poly(0, {0, 1e-4})}}); }
/// X errs by 1e-5 x^2: 1 um at 10 mm, 0.25 um at 5, 2.25 um at 15.
Machine bent_x() { return three_axes({{"EXX", poly(0, {0, 0, 1e-5})}}); }

RewriteJob with_radius(double radius) {
  RewriteJob job = plain_job();
  job.setup.radii[1] = radius;
  return job;
}

constexpr const char* kContour =
    "G21 G90 G17\nG0 X-40 Y-10 Z5\nG1 Z0 F100\nG41 D1 G1 X-10 Y0 F200\nG1 X20\nG3 X30 Y10 I0 J10\nG1 "
    "Y30\nX-10\n"
    "G40 G1 X-40 Y40\nG0 Z5\nM2\n";

std::string without(std::string text, const std::string& part) {
  for (std::size_t at; (at = text.find(part)) != std::string::npos;) text.erase(at, part.size());
  return text;
}

/// What is corrected is the contour: the words are those of the same program without compensation.
TEST(CutterCompensation, TheContourIsCorrected) {
  const auto on = rewrite(long_x(), kContour, with_radius(5));
  ASSERT_TRUE(on.report.complete) << on.findings();
  const auto off = rewrite(long_x(), without(without(kContour, "G41 D1 "), "G40 "));
  ASSERT_TRUE(off.report.complete) << off.findings();
  EXPECT_EQ(without(without(on.text, "G41 D1 "), "G40 "), off.text);
  EXPECT_NE(on.text.find("G41 D1 G1 X-9.9990 Y0 F200"), std::string::npos) << on.text;
  EXPECT_EQ(on.report.cutter_radius, 5);
  // beside the blocks along Y the cutter's centre is 5 mm off in X: 1e-4 * 5
  EXPECT_NEAR(on.report.cutter_residual, 0.5e-3, 1e-6);
}

TEST(CutterCompensation, ARadiusOfZeroCostsNothing) {
  const auto on = rewrite(long_x(), kContour, with_radius(0));
  ASSERT_TRUE(on.report.complete) << on.findings();
  EXPECT_EQ(on.report.cutter_residual, 0);
}

/// At x = 10 a cutter of 5 mm on the left runs at x = 5, where 0.75 um are missing; on the right at x =
/// 15: 1.25.
TEST(CutterCompensation, WhatIsLeftIsThatOfItsSide) {
  const auto program = [](const char* code) {
    return std::string("G0 X10 Y-30 Z5\n") + code + " D1\nG1 Y-10 F100\nY10\nG40 Y30\nM2\n";
  };
  const auto left = rewrite(bent_x(), program("G41"), with_radius(5));
  ASSERT_TRUE(left.report.complete) << left.findings();
  EXPECT_NEAR(left.report.cutter_residual, 0.75e-3, 1e-6);
  EXPECT_TRUE(rewrite(bent_x(), program("G42"), with_radius(5)).has("E-TOL"));
}

TEST(CutterCompensation, TheSideTurnsWithTheWorkOffset) {
  // Rz(90 degrees) (x, -10) = (10, x): the program's +X is the machine's +Y at x = 10
  const auto program = [](const char* code) {
    return std::string("G0 X-30 Y-10 Z5\n") + code + " D1\nG1 X-10 F100\nX10\nG40 X30\nM2\n";
  };
  RewriteJob job = with_radius(5);
  job.setup.work_offsets[0] = WorkOffset{{}, std::acos(-1.0) / 2};
  const auto left = rewrite(bent_x(), program("G41"), job);
  ASSERT_TRUE(left.report.complete) << left.findings();
  EXPECT_NEAR(left.report.cutter_residual, 0.75e-3, 1e-6);
  EXPECT_TRUE(rewrite(bent_x(), program("G42"), job).has("E-TOL"));
}

/// Z bends: 10 um over the chord of 100 mm.
Machine bow() { return three_axes({{"EZX", poly(0, {0, 0, 4e-6})}}); }

TEST(CutterCompensation, LongBlocksAreSplitAwayFromTheirEnds) {
  const std::string program = "G0 X-60 Y-40 Z5\nG41 D1 G1 X-60 Y0 F100\nX60\nY40\nG40 Y80\nM2\n";
  RewriteJob job = with_radius(5);
  job.tolerance = 4e-3;
  const auto result = rewrite(bow(), program, job);
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.report.blocks.split, 1U) << result.text;
  EXPECT_GE(result.report.shortest_split, 20) << "four radii";
}

TEST(CutterCompensation, BlocksThatMayNotBeSplitStayWholeOrAreRefused) {
  // 30 mm, less than twice four radii: 4e-6 * 15^2 = 0.9 um stay
  const auto program = [](const char* end) {
    return std::string("G0 X-15 Y-40 Z5\nG41 D1 G1 X-15 Y0 F100\nX") + end + "\nY40\nG40 Y80\nM2\n";
  };
  const auto whole = rewrite(bow(), program("15"), with_radius(5));
  EXPECT_FALSE(whole.has("E-TOL")) << whole.findings();
  EXPECT_EQ(whole.report.blocks.split, 0U);
  // 36 mm: 4e-6 * 18^2 = 1.3 um
  EXPECT_TRUE(rewrite(bow(), program("21"), with_radius(5)).has("E-TOL"));
}

TEST(CutterCompensation, TheBlocksThatBeginAndEndItAreNeverSplit) {
  const std::string program = "G0 X-60 Y0 Z5\nG41 D1 G1 X60 F100\nY40\nG40 X-60\nM2\n";
  const auto result = rewrite(bow(), program, with_radius(0));
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.report.blocks.split, 0U) << result.text;
  EXPECT_EQ(result.report.lines_out, 5U);
}

/// Straightness along Z: X is 1e-5 z off. A plunge gets no X word.
TEST(CutterCompensation, AMotionAcrossThePlaneGetsNoWordOfIt) {
  const Machine machine = three_axes({{"EXZ", poly(2, {0, 1e-5})}});
  const std::string program =
      "G0 X0 Y-40 Z0\nG41 D1 G1 Y0 F100\nG1 Y30\nG1 Z-50\nG1 X0 Z-55\nG1 Y60\nG40 Y90\nM2\n";
  const auto result = rewrite(machine, program, with_radius(5));
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_NE(result.text.find("G1 Z-50\nG1 X0 Z-55\nG1 Y60 X0.000"), std::string::npos) << result.text;
  // 1.5 um would be missing in X at the bottom
  const std::string deep = "G0 X0 Y-40 Z0\nG41 D1 G1 Y0 F100\nG1 Y30\nG1 Z-150\nG1 Y60\nG40 Y90\nM2\n";
  EXPECT_TRUE(rewrite(machine, deep, with_radius(5)).has("E-TOL"));
}

struct Under {
  const char *block, *code;
};
void PrintTo(const Under& under, std::ostream* out) { *out << under.block; }

class UnderCompensation : public ::testing::TestWithParam<Under> {};

TEST_P(UnderCompensation, IsRefused) {
  const std::string program = std::string("T1 M6\nG0 X0 Y-40 Z5\nG41 D1 G1 Y0 F100\nG1 Y30\n") +
                              GetParam().block + "\nG40 G1 Y90\nM2\n";
  RewriteJob job = with_radius(5);
  job.setup.tool_change_keeps_place = true;
  job.setup.start = {0.0, 0.0, 0.0};
  ASSERT_TRUE(
      rewrite(long_x(), "T1 M6\nG0 X0 Y-40 Z5\nG41 D1 G1 Y0 F100\nG1 Y30\nG1 X20\nG40 G1 Y90\nM2\n", job)
          .report.complete);
  EXPECT_TRUE(rewrite(long_x(), program, job).has(GetParam().code)) << rewrite(long_x(), program, job).text;
}

INSTANTIATE_TEST_SUITE_P(
    Blocks, UnderCompensation,
    ::testing::Values(Under{"G53 G0 Z0", "E-CUTCOM"}, Under{"G28 Z5", "E-CUTCOM"},
                      Under{"G92 X0", "E-CUTCOM"}, Under{"G55", "E-CUTCOM"}, Under{"G18", "E-CUTCOM"},
                      Under{"G20", "E-CUTCOM"}, Under{"G43.1 Z5", "E-CUTCOM"}, Under{"M6", "E-CUTCOM"},
                      Under{"G81 X9 Z-5 R1", "E-CUTCOM"}, Under{"M2", "E-CUTCOM"},
                      Under{"G42 D1", "E-CUTCOM"}, Under{"G41 D1", "E-CUTCOM"}, Under{"G41.2 D1", "E-GCODE"},
                      Under{"G1 X-3", "E-CUTCOM"},             // inside corner, 3 < 5.25 mm
                      Under{"G3 X-8 Y30 I-4 J0", "E-CUTCOM"},  // around the cutter, 4 < 5 mm
                      Under{"G3 X0 Y30 I-20 J0 P2", "E-CUTCOM"}));

TEST(CutterCompensation, ItsRadiusMustBeKnownAndItsBeginningLonger) {
  const auto program = [](const char* start) {
    return std::string("G0 X0 Y-40 Z5\n") + start + "\nG1 Y30\nG40 G1 Y90\nM2\n";
  };
  const auto refused = [&](const char* start, const RewriteJob& job) {
    return rewrite(long_x(), program(start), job).has("E-CUTCOM");
  };
  EXPECT_FALSE(refused("G41 D1 G1 Y0 F100", with_radius(5)));
  EXPECT_TRUE(refused("G41 D1 G1 Y0 F100", plain_job()));
  EXPECT_TRUE(refused("G41 D2 G1 Y0 F100", with_radius(5)));
  EXPECT_TRUE(refused("G41 G1 Y0 F100", with_radius(5))) << "no tool in the spindle";
  EXPECT_TRUE(refused("G41 D1 G1 Y-35 F100", with_radius(5))) << "5 mm";
  EXPECT_TRUE(refused("G41 D1 G1 Z-35 F100", with_radius(5)));
  EXPECT_TRUE(refused("G41 D1\nG3 Y0 R20 F100", with_radius(5)));
  EXPECT_TRUE(refused("G18 G41 D1 G1 X30 F100", with_radius(5)));
  EXPECT_TRUE(refused("G41.1 G1 Y0 F100", with_radius(5)));
  EXPECT_TRUE(refused("G41.1 D-3 G1 Y0 F100", with_radius(5)));
  EXPECT_FALSE(refused("G41.1 D10 G1 Y0 F100", plain_job()));
  RewriteJob table = plain_job();
  table.setup.tools[1].diameter = -10;
  EXPECT_TRUE(refused("G41 D1 G1 Y0 F100", table));
  table.setup.tools[1].diameter = 10;
  EXPECT_FALSE(refused("G41 D1 G1 Y0 F100", table));
  table.setup.loaded_tool = 1;
  EXPECT_FALSE(refused("G41 G1 Y0 F100", table));
  EXPECT_FALSE(refused("G41 D0 G1 Y0 F100", table)) << "LinuxCNC: the tool in the spindle";
}

}  // namespace
}  // namespace abbe
