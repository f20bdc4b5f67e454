#include "abbe/verify/nurbs.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>

#include "abbe/machine/read_profile.h"
#include "abbe/verify/test_programs.h"

namespace abbe::verifying {
namespace {

constexpr double kExact = 1e-12;

// The curve of a tilted half parabola: (1-u)^2 P0 + 2u(1-u) P1 + u^2 P2 at u = 0.25 is (9 P0 + 6 P1 + P2)
// / 16.
TEST(Nurbs, OfOrderThreeIsAParabola) {
  const Nurbs parabola{3, {0, 0, 0, 1, 1, 1}, {1, 1, 1}, {{16, 0, 0}, {0, 16, 0}, {0, 0, 16}}};
  ASSERT_TRUE(is_curve(parabola));
  EXPECT_NEAR((point_of(parabola, 0.25) - Vec3(9, 6, 1)).norm(), 0, kExact);
  EXPECT_NEAR((point_of(parabola, 1) - Vec3(0, 0, 16)).norm(), 0, kExact);
}

TEST(Nurbs, WeightsPullTheCurve) {
  const Nurbs pulled{2, {0, 0, 1, 1}, {1, 3}, {{0, 0, 0}, {4, 0, 0}}};
  EXPECT_NEAR(point_of(pulled, 0.5).x(), 3, kExact) << "3 of 4 shares";
}

TEST(Nurbs, InnerKnotsSwitchBetweenPoints) {
  // order 2: straight pieces from point to point
  const Nurbs bent{2, {0, 0, 1, 3, 3}, {1, 1, 1}, {{0, 0, 0}, {8, 0, 0}, {8, 6, 0}}};
  ASSERT_TRUE(is_curve(bent));
  EXPECT_NEAR((point_of(bent, 0.5) - Vec3(4, 0, 0)).norm(), 0, kExact);
  EXPECT_NEAR((point_of(bent, 1) - Vec3(8, 0, 0)).norm(), 0, kExact);
  EXPECT_NEAR((point_of(bent, 2) - Vec3(8, 3, 0)).norm(), 0, kExact);
  EXPECT_FALSE(is_curve({2, {0, 0, 1, 2, 3}, bent.weights, bent.points})) << "it would not end at its point";
}

/// A cubic by its four control points.
std::string curve(const std::array<const char*, 4>& points, const char* weight = "1.",
                  const char* knot = "1.") {
  return fmt::format(
      "G21 G90 G94 G17 G54\nG0{0}\nF100.\nG6.2 P4 K0.{0}\nK0.{1}\nK0.{2} "
      "R{4}\nK0.{3}\nK1.\nK1.\nK1.\nK{5}\nM30\n",
      points[0], points[1], points[2], points[3], weight, knot);
}
const std::string kOriginal =
    curve({" X10. Y20. Z-1.", " X20. Y50. Z-1.", " X40. Y60. Z-1.", " X60. Y30. Z-1."});
// x' = x / 1.0001, z' = z - 0.007: an affine movement, so every control point by its own
const std::string kOutput = curve({" X9.9990 Y20. Z-1.0070", " X19.9980 Y50. Z-1.0070",
                                   " X39.9960 Y60. Z-1.0070", " X59.9940 Y30. Z-1.0070"});

VerifyReport judge(const std::string& machine, const std::string& original, const std::string& output) {
  VerifyJob job = ideal_job();
  auto profile = *embedded_profile("fanuc");
  profile.numbers.decimals_mm = 4;
  job.setup.profile = std::make_shared<const Profile>(profile);
  return verify(plan_of(machine), original, output, job);
}

std::string affine(int sign) {
  return fmt::format(
      "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[axis.X]\n[axis.Y]\n[axis.Z]\n[errors]\nEXX = {{ poly "
      "= "
      "[0, {}] }}\nEZZ = {}\n",
      sign * 0.1, sign * 7);
}

TEST(Nurbs, MovedByTheirOwnCorrectionAgree) {
  const VerifyReport good = judge(affine(1), kOriginal, kOutput);
  EXPECT_TRUE(good.agrees) << texts(good);
  EXPECT_NEAR(good.before.max, std::hypot(6, 7) * um, 0.01 * um) << "60 mm times 0.1 um, and 7 um of Z";
  EXPECT_LT(good.after.max, 0.1 * um);
  EXPECT_FALSE(judge(affine(1), kOriginal, kOriginal).agrees) << "not compensated";
  EXPECT_FALSE(judge(affine(-1), kOriginal, kOutput).agrees) << "the wrong sign";
}

TEST(Nurbs, WhatIsChangedIsFound) {
  const auto with = [](const char* second, const char* weight, const char* knot) {
    return curve({" X10. Y20. Z-1.", second, " X40. Y60. Z-1.", " X60. Y30. Z-1."}, weight, knot);
  };
  const char* const right = " X20. Y50. Z-1.";
  EXPECT_TRUE(judge(kPerfect, kOriginal, with(right, "1.", "1.")).agrees);
  EXPECT_FALSE(judge(kPerfect, kOriginal, with(" X20. Y50.01 Z-1.", "1.", "1.")).agrees) << "another point";
  EXPECT_FALSE(judge(kPerfect, kOriginal, with(right, "1.01", "1.")).agrees) << "another weight";
  EXPECT_FALSE(judge(kPerfect, kOriginal, with(right, "1.", "1.5")).agrees) << "another knot";
}

// H30: the control alarms if a curve does not begin where the tool stands.
TEST(Nurbs, TheFirstPointIsWhereTheToolStands) {
  const std::string apart =
      "G21 G90 G94 G17 G54\nG0 X10. Y20. Z-1.\nG6.2 P2 K0. X10.001 Y20. Z-1.\nK0. X20.\nK1.\nK1.\nM30\n";
  const VerifyReport report = judge(kPerfect, apart, apart);
  ASSERT_FALSE(report.agrees);
  EXPECT_EQ(report.diagnostics[0].code, "E-SPLINE") << texts(report);
}

}  // namespace
}  // namespace abbe::verifying
