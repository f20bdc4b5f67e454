#include "abbe/verify/reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "abbe/core/test_files.h"

namespace abbe::verifying {
namespace {

using abbe::testing::TestFile;

constexpr double kExact = 1e-12;  // mm

ControlSetup setup_at_zero() {
  ControlSetup setup;
  setup.work_offsets[0] = WorkOffset{};
  setup.start = {0.0, 0.0, 0.0};
  return setup;
}

struct Listing {
  std::vector<ListedMotion> motions;
  Diagnostics diagnostics;
};

Listing list(const std::string& program, const ControlSetup& setup = setup_at_zero()) {
  const TestFile file(program);
  Listing listing;
  listing.diagnostics =
      list_motions(file.path(), "p.ngc", setup, [&](const ListedMotion& m) { listing.motions.push_back(m); });
  return listing;
}

void expect_end(const ListedMotion& motion, double x, double y, double z) {
  EXPECT_LT((motion.end - Vec3(x, y, z)).norm(), kExact)
      << "line " << motion.line << " ended at " << motion.end.transpose();
}

std::string first_code(const Listing& listing) {
  return listing.diagnostics.empty() ? "" : listing.diagnostics.front().code;
}

using Kind = ListedMotion::Kind;

TEST(Reader, ReadsBlanksCaseAndPointsAnywhere) {
  const Listing l = list("g0 1 x 1 . 5 y-.5z+2.\r\n\t/G1X2F100(a)Y 3;b\n");
  ASSERT_EQ(l.motions.size(), 2u) << to_text(l.diagnostics.empty() ? Diagnostic{} : l.diagnostics.front());
  EXPECT_EQ(l.motions[0].kind, Kind::line);
  expect_end(l.motions[0], 1.5, -0.5, 2);
  expect_end(l.motions[1], 2, 3, 2);
  EXPECT_EQ(l.motions[1].line, 2u);
}

TEST(Reader, FramesAddUp) {
  ControlSetup setup = setup_at_zero();
  setup.work_offsets[1] = WorkOffset{{100, 20, -5}, 30 * deg};
  ToolEntry tool;
  tool.number = 3;
  tool.offset = {0, 0, 50};
  setup.tools[3] = tool;
  const Listing l =
      list("G55 G43 H3 G0 X10 Y0 Z0\nG92 X0 Y0\nG0 X1\nG91 X1\nG90 G53 G0 Z7\nG0 Z1\nG54 G49 G0 X2\n", setup);
  ASSERT_EQ(l.motions.size(), 6u) << first_code(l);
  const double c = std::cos(30 * deg), s = std::sin(30 * deg);
  // m = Rz(rot) (p + g92) + origin + tool offset; G92 X0 at u = 10 makes g92 = 10
  expect_end(l.motions[0], 100 + 10 * c, 20 + 10 * s, 45);
  expect_end(l.motions[1], 100 + 11 * c, 20 + 11 * s, 45);
  expect_end(l.motions[2], 100 + 12 * c, 20 + 12 * s, 45);
  expect_end(l.motions[3], 100 + 12 * c, 20 + 12 * s, 7);
  expect_end(l.motions[4], 100 + 12 * c, 20 + 12 * s, 46);
  EXPECT_NEAR(l.motions[5].end.x(), 2 + 10, kExact) << "G92 stays in force in the other frame";
}

TEST(Reader, G52AndG10MoveTheFrameNotTheMachine) {
  const Listing l = list(
      "G0 X10 Y20 Z30\nG52 X5\nG0 X0\nG10 L2 P1 X100 Y0 Z0\nG0 X0\nG10 L20 P1 X7\nG0 X0\nG92.1\nG0 X0 "
      "Y1\nG92.3\n");
  ASSERT_EQ(l.motions.size(), 5u);
  expect_end(l.motions[1], 5, 20, 30);
  expect_end(l.motions[2], 105, 20, 30);
  // at m = 105 the reading is 7: origin = 105 - 7 - 5 = 93, so X0 is at 93 + 5
  expect_end(l.motions[3], 98, 20, 30);
  expect_end(l.motions[4], 93, 1, 30);
  EXPECT_EQ(first_code(l), "E-G92");
}

TEST(Reader, InchesScaleLengthsOnly) {
  const Listing l = list("G20 G0 X1 Y-0.5\nG21 X1\nG20 G2 X1 Y0 I0.5 J0\n");
  expect_end(l.motions[0], 25.4, -12.7, 0);
  expect_end(l.motions[1], 1, -12.7, 0);
}

TEST(Reader, ArcsInAllPlanes) {
  const Listing l = list(
      "G0 X10 Y0 Z0\nG3 F100 X0 Y10 I-10\nG2 X10 Y0 R10\nG2 R-10 X0 Y10\nG90.1 G3 X-10 Y0 I0 J0 P2\nG91.1\n"
      "G0 X0 Y0 Z10\nG18 G2 Z0 X10 K-10\nG19 G3 Y5 Z5 J5\nG17 G2 I5 Z3\n");
  ASSERT_EQ(l.motions.size(), 9u) << first_code(l);
  EXPECT_EQ(l.motions[1].turns, 1);
  EXPECT_LT((l.motions[1].centre - Vec3(0, 0, 0)).norm(), kExact);
  EXPECT_EQ(l.motions[2].turns, -1);
  EXPECT_LT((l.motions[2].centre - Vec3(0, 0, 0)).norm(), 1e-12);
  EXPECT_LT((l.motions[3].centre - Vec3(0, 0, 0)).norm(), 1e-12) << "clockwise and long: left of the chord";
  EXPECT_EQ(l.motions[4].turns, 2);
  EXPECT_EQ(l.motions[6].plane, 18);
  EXPECT_LT((l.motions[6].centre - Vec3(0, 0, 0)).norm(), kExact);
  EXPECT_EQ(l.motions[7].plane, 19);
  EXPECT_LT((l.motions[7].centre - Vec3(10, 5, 0)).norm(), kExact);
  expect_end(l.motions[8], 10, 5, 3);
}

TEST(Reader, ArcGoesThroughTheRightQuadrant) {
  ControlSetup setup = setup_at_zero();
  setup.work_offsets[0]->rotation = 90 * deg;
  const TestFile file("G0 X10 Y0 Z0\nG3 X0 Y10 Z2 I-10 F1\nG18 G3 X10 Z2 R20\nG2 X10 Z2 I-1\n");
  auto opened = ProgramReader::open(file.path(), "p", setup, {});
  auto& reader = std::get<ProgramReader>(opened);
  std::vector<Motion> motions;
  for (auto item = reader.next(); item != ProgramReader::Item::end; item = reader.next()) {
    ASSERT_NE(item, ProgramReader::Item::refused) << to_text(reader.refusal());
    if (item == ProgramReader::Item::motion) motions.push_back(reader.motion());
  }
  ASSERT_EQ(motions.size(), 4u);
  const double h = 10 / std::numbers::sqrt2;
  // In the program the middle is (h, h, 1); the frame turns it by 90 deg: (-h, h, 1).
  EXPECT_LT((point_at(motions[1], 0.5) - Vec3(-h, h, 1)).norm(), 1e-12);
  EXPECT_LT((point_at(motions[1], 1) - motions[1].end.at).norm(), 1e-12);
  // G18 G3 is counter-clockwise from Z to X: from (X0 Z2) to (X10 Z2), centre at (X5, Z2 + h or - h).
  // In (Z, X) the chord points along +X; left of it is -Z, where the centre of the minor arc lies.
  const double k = std::sqrt(400.0 - 25.0);
  EXPECT_NEAR(point_at(motions[2], 0.5).z(), 2 - k + 20, 1e-9);
  EXPECT_NEAR(point_at(motions[2], 0.5).y(), 5, 1e-9) << "program X is machine Y here";
  EXPECT_NEAR(std::abs(motions[3].arc.sweep), 2 * std::numbers::pi, 1e-15);
  EXPECT_LT(motions[3].arc.sweep, 0);
  for (const Motion& m : motions) {
    if (m.kind != MotionKind::arc) continue;
    const Vec3 difference = (point_at(m, 0.3 + 1e-6) - point_at(m, 0.3 - 1e-6)) / 2e-6;
    EXPECT_LT((difference - derivative_at(m, 0.3)).norm(), 1e-6 * difference.norm())
        << "DerivativeEqualsDifference";
  }
}

TEST(Reader, CyclesAsLinuxCncExpandsThem) {
  const Listing l = list(
      "G0 X1 Y1 Z20\nG98 G81 X5 Y6 Z-3 R2 F10\nX8\nG99 G83 Y9 Z-1 R1 Q1\nG80\nG91 G98 G82 X1 Y0 Z-1 R-0.5 P2 "
      "L2\n");
  ASSERT_TRUE(l.diagnostics.empty()) << to_text(l.diagnostics.front());
  const std::vector<std::array<double, 4>>
      expected = {{0, 1, 1, 20},                                                       // G0
                  {0, 5, 6, 20},    {0, 5, 6, 2},    {1, 5, 6, -3},    {0, 5, 6, 20},  // G81
                  {0, 8, 6, 20},    {0, 8, 6, 2},    {1, 8, 6, -3},    {0, 8, 6, 20},  // X8
                  {0, 8, 9, 20},    {0, 8, 9, 1},    {1, 8, 9, 0},     {0, 8, 9, 1},
                  {0, 8, 9, 0.254}, {1, 8, 9, -1},   {0, 8, 9, 1},     {0, 9, 9, 1},
                  {0, 9, 9, 0.5},   {1, 9, 9, -0.5}, {0, 9, 9, 1},  // G91 L2, R from Z, Z from R
                  {0, 10, 9, 1},    {0, 10, 9, 0.5}, {1, 10, 9, -0.5}, {0, 10, 9, 1}};
  ASSERT_EQ(l.motions.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(l.motions[i].kind == Kind::line, expected[i][0] == 1) << i;
    expect_end(l.motions[i], expected[i][1], expected[i][2], expected[i][3]);
  }
}

TEST(Reader, CycleLevelsAreThoseOfTheSequence) {
  // The sequence begins at 30. G99: the next hole is reached at its own R, straight from the last one's.
  const Listing l = list(
      "G0 X0 Y0 Z30\nG99 G85 X1 Y0 Z0 R10 F9\nX2 R20\nG98 X3 R5\nG80 G91 G99 G81 X1 Y0 Z-8 R-2\nX1\nG4 P1 "
      "G90 G0 X0\n");
  ASSERT_TRUE(l.diagnostics.empty()) << to_text(l.diagnostics.front());
  const std::vector<std::array<double, 4>> expected = {
      {0, 0, 0, 30},                                                              // G0
      {0, 1, 0, 30}, {0, 1, 0, 10}, {1, 1, 0, 0},  {1, 1, 0, 10}, {0, 1, 0, 10},  // G85
      {0, 2, 0, 20}, {1, 2, 0, 0},  {1, 2, 0, 20}, {0, 2, 0, 20},                 // R above where it stands
      {0, 3, 0, 20}, {0, 3, 0, 5},  {1, 3, 0, 0},  {1, 3, 0, 5},  {0, 3, 0, 30},  // G98: back to 30
      {0, 4, 0, 30}, {0, 4, 0, 28}, {1, 4, 0, 20}, {0, 4, 0, 28},                 // G91: R from 30
      {0, 5, 0, 28}, {1, 5, 0, 20}, {0, 5, 0, 28},                                // again from 30
      {0, 0, 0, 28}};
  ASSERT_EQ(l.motions.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(l.motions[i].kind == Kind::line, expected[i][0] == 1) << i;
    expect_end(l.motions[i], expected[i][1], expected[i][2], expected[i][3]);
  }
}

TEST(Reader, HomeLeavesAxesUnknown) {
  const Listing l = list("G0 X1 Y2 Z3\nG91 G28 Z1\nG90 G0 X5\nG0 Z9\n");
  ASSERT_EQ(l.motions.size(), 5u);
  expect_end(l.motions[1], 1, 2, 4);
  EXPECT_EQ(l.motions[2].known, 3u);
  EXPECT_EQ(l.motions[3].known, 3u);
  EXPECT_EQ(l.motions[4].known, 7u);
}

TEST(Reader, NothingRunsBehindTheEnd) {
  EXPECT_EQ(list("%\nO12 (name)\nG0 X1\n%\nG99999 rubbish #1\n").motions.size(), 1u);
  EXPECT_EQ(list("G0 X1 M2\nG0 X2 U9\n").motions.size(), 1u);
  EXPECT_EQ(list(std::string("\0\0\0\n%\nG0X1\nM30\n%", 17)).motions.size(), 1u);
}

struct Refusal {
  const char* program;
  const char* code;
  std::size_t line, column;
};

class Refuses : public ::testing::TestWithParam<Refusal> {};

TEST_P(Refuses, WithCodeAndPlace) {
  const Refusal& r = GetParam();
  const Listing l = list(r.program);
  ASSERT_FALSE(l.diagnostics.empty()) << r.program;
  const Diagnostic& d = l.diagnostics.front();
  EXPECT_EQ(d.code, r.code) << r.program << to_text(d);
  EXPECT_EQ(d.place.line, r.line) << r.program;
  EXPECT_EQ(d.place.column, r.column) << r.program;
  EXPECT_FALSE(d.why.empty());
  EXPECT_FALSE(d.fix.empty());
}

INSTANTIATE_TEST_SUITE_P(
    All, Refuses,
    ::testing::Values(
        Refusal{"G0 X1\nG1 X\x80 F1\n", "E-NUMBER", 2, 4}, Refusal{"G0 X1 \x80\n", "E-CHAR", 1, 7},
        Refusal{"G0 X1 (a\n", "E-COMMENT", 1, 7}, Refusal{"G0 (a(b) X1\n", "E-COMMENT", 1, 6},
        Refusal{"G0 X#1\n", "E-EXPR", 1, 5}, Refusal{"#1=2\n", "E-EXPR", 1, 1},
        Refusal{"G0 X[1]\n", "E-EXPR", 1, 5}, Refusal{"G1 A10 F1\n", "E-ROTARY", 1, 4},
        Refusal{"G1 U10 F1\n", "E-AXIS", 1, 4}, Refusal{"G1 X1 E1\n", "E-WORD", 1, 7},
        Refusal{"G0 X1E2\n", "E-WORD", 1, 6}, Refusal{"G41 D1\n", "E-CUTCOM", 1, 1},
        Refusal{"G5 X1\n", "E-GCODE", 1, 1}, Refusal{"M98 P1\n", "E-MCODE", 1, 1},
        Refusal{"O1 sub\n", "E-NUMBER", 1, 4}, Refusal{"O1 G0\n", "E-OWORD", 1, 1},
        Refusal{"G0\nO2\n", "E-OWORD", 2, 1}, Refusal{"G0 X1 X2\n", "E-BLOCK", 1, 7},
        Refusal{"G0 G1 X1\n", "E-BLOCK", 1, 4}, Refusal{"M3 M4\n", "E-BLOCK", 1, 4},
        Refusal{"X1\n", "E-MODE", 1, 1}, Refusal{"G0 X1 I2\n", "E-WORD", 1, 7},
        Refusal{"G0 X1 H2\n", "E-WORD", 1, 7}, Refusal{"G55 G0 X1\n", "E-WCS", 1, 1},
        Refusal{"G91 G10 L2 P1 X1\n", "E-G10", 1, 9}, Refusal{"G10 L1 P1 Z1\n", "E-G10", 1, 5},
        Refusal{"G28 X0\nG1 X5 F1\n", "E-POS", 2, 1}, Refusal{"G28 X0\nG92 X5\n", "E-POS", 2, 1},
        Refusal{"G0 X0 Y0 Z0\nT1 M6\nG1 X5 F1\n", "E-POS", 3, 1}, Refusal{"G43 H7\n", "E-TOOL", 1, 1},
        Refusal{"M6\n", "E-TOOL", 1, 1}, Refusal{"G91 G53 G0 X1\n", "E-G53", 1, 5},
        Refusal{"G53 G2 X1 I1\n", "E-G53", 1, 1}, Refusal{"G1 F1\nG2 X1 Y1\n", "E-ARC", 2, 1},
        Refusal{"G2 X0 Y0 R5 F1\n", "E-ARC", 1, 10}, Refusal{"G2 X10 Y0 I4 F1\n", "E-ARC", 1, 1},
        Refusal{"G2 X10 R4.9 F1\n", "E-ARC", 1, 8}, Refusal{"G81 X1 Z-1\n", "E-CYCLE", 1, 1},
        Refusal{"G81 Z1 R0\n", "E-CYCLE", 1, 1}, Refusal{"G83 Z-1 R0 Q0\n", "E-CYCLE", 1, 12},
        Refusal{"G93 G1 X1\n", "E-FEED", 1, 1}, Refusal{"G4 P1 X1\n", "E-MODE", 1, 7},
        Refusal{"G1 X1 F0\n", "E-FEED", 1, 1}, Refusal{"F0\nG0 X2\nG1 X1\n", "E-FEED", 3, 1},
        Refusal{"G92 X1 G1\n", "E-BLOCK", 1, 1}, Refusal{"G4 P1 M62 P1\n", "E-BLOCK", 1, 11},
        Refusal{"X1 . 5 . 2\n", "E-NUMBER", 1, 8}, Refusal{"N1 G0 X99999999999\n", "E-NUMBER", 1, 7},
        Refusal{"G0 X1 N5\n", "E-BLOCK", 1, 7}, Refusal{"G0 /X1\n", "E-CHAR", 1, 4},
        Refusal{"G0 X1\r\rY2\n", "E-CHAR", 1, 6}));

TEST(Reader, LongestLineIsReadLongerOneRefused) {
  const std::string fits = "G0 X1 (" + std::string(246, 'a') + ")";
  ASSERT_EQ(fits.size(), 254u);
  EXPECT_TRUE(list(fits + "\r\n").diagnostics.empty());
  EXPECT_EQ(first_code(list("(" + fits.substr(7) + "(" + std::string(8, 'b') + ")\n")), "E-LINELEN");
  EXPECT_EQ(first_code(list("(" + std::string(200000, 'a') + ")\n")), "E-LINELEN");
}

}  // namespace
}  // namespace abbe::verifying
