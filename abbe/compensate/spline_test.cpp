// NURBS (G6.2): what is written for their blocks, and why they are refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "abbe/compensate/rewrite_fixture.h"
#include "abbe/machine/read_profile.h"

namespace abbe::testing {
namespace {

using ::testing::HasSubstr;

/// X goes 0.1 um too far per mm, Z stands 20 um too low; with `bow`, Y bends by 5 um on 50 mm.
Machine machine(bool bow = false) {
  return three_axes(
      {{"EXX", poly(0, {0, 1e-4})}, {"EZZ", poly(2, {-0.020})}, {"EYX", poly(0, {0, 0, bow ? 2e-6 : 0.0})}});
}

Rewritten fanuc(const std::string& blocks, const Machine& on, double tolerance = 1e-3) {
  RewriteJob job = plain_job();
  job.setup.profile = embedded_profile("fanuc");
  job.setup.start = {0.0, 0.0, 0.0};
  job.tolerance = tolerance;
  return rewrite(on, "G21 G90 G94 G17 G54\nG0 X10. Y20. Z0.\nF100.\n" + blocks + "M30\n", job);
}

// x' = x / 1.0001, z' = z + 0.020. Z is named in the first block, so it stays as corrected.
TEST(Splines, ControlPointsAreMovedAndNothingElse) {
  const Rewritten result = fanuc(
      "G6.2 P3 K0. X10. Y20. Z0. (curve)\nK0. X30. Y60. R2.\n(between)\nK0. X50. Y20. "
      "Z-5.\nK1.\nK1.\nK1.\nG0 Z50.\n",
      machine());
  EXPECT_THAT(
      result.text,
      HasSubstr("G0 X9.999 Y20. Z0.020\nF100.\nG6.2 P3 K0. X9.999 Y20. Z0.020 (curve)\nK0. X29.997 Y60. "
                "R2.\n(between)\nK0. X49.995 Y20. Z-4.980\nK1.\nK1.\nK1.\nG0 Z50.020\n"))
      << result.findings();
}

TEST(Splines, WithoutErrorsNoByteChanges) {
  const std::string blocks =
      "G6.2 P3 K0. X10. Y20. Z0.\nK0. X30. Y60. R2.\nK0. X50. Y20.\nK1.\nK1.\nK1.\nG0 Z50.\n";
  EXPECT_THAT(fanuc(blocks, three_axes({})).text, HasSubstr(blocks));
}

TEST(Splines, WhatIsNotSureIsRefused) {
  const auto refused = [](const std::string& blocks) {
    const Rewritten result = fanuc(blocks, machine());
    return result.has("E-SPLINE") && result.report.diagnostics.size() == 1 ? std::string()
                                                                           : result.findings() + "?";
  };
  const std::string end = "K0. X30. Y60.\nK0. X50. Y20.\nK1.\nK1.\nK1.\n";
  EXPECT_EQ(refused("G6.2 P3 K0. X10.001 Y20.\n" + end), "") << "it does not begin where the tool stands";
  EXPECT_EQ(refused("G91\nG6.2 P3 K0. X0. Y0.\n" + end), "");
  EXPECT_EQ(refused("G6.2 P3 K0. X10. Y20.\nK0. X30. Y60. Z1.\nK0. X50. Y20.\nK1.\nK1.\nK1.\n"), "")
      << "Z is not named in the first block";
  EXPECT_EQ(refused("G6.2 P3 K0. X10. Y20.\nK0. X30. Y60.\nG0 Z50.\n"), "") << "knots are missing";
  EXPECT_EQ(refused("G6.2 P3 K0. X10. Y20.\nK1. X30. Y60.\nK2. X50. Y20.\nK3.\nK4.\nK5.\n"), "")
      << "it does not end at its points";
}

TEST(Splines, WhatBendsBetweenTheKnotsIsRefused) {
  const std::string line = "G6.2 P2 K0. X10. Y20.\nK0. X110. Y20.\nK1.\nK1.\n";
  const Rewritten result = fanuc(line, machine(true));
  EXPECT_TRUE(result.has("E-SPLINE")) << "one straight piece, and Y bends by 5 um: " << result.text;
  EXPECT_FALSE(fanuc(line, machine(true), 20e-3).has("E-SPLINE"));
}

TEST(Splines, ARefusedCodeIsNamedOnceNotForEachOfItsBlocks) {
  RewriteJob job = plain_job();
  job.setup.start = {0.0, 0.0, 0.0};
  const Rewritten result = rewrite(machine(),
                                   "G21 G90 G94 G17 G54\nG0 X0 Y0 Z0\nF100\nG5.2 X0 Y1 P1 L3\nX2 Y2 P1\nX2 "
                                   "Y0 P1\nX0 Y0 P2\nG1 X5 Q1\nM2\n",
                                   job);
  ASSERT_EQ(result.report.diagnostics.size(), 2U) << result.findings();
  EXPECT_EQ(result.report.diagnostics[0].code, "E-GCODE");
  EXPECT_EQ(result.report.diagnostics[1].code, "E-WORD") << "of a motion that is known again";
}

}  // namespace
}  // namespace abbe::testing
