#include "abbe/compensate/tool_vectors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "abbe/chain/test_plan.h"
#include "abbe/core/units.h"

namespace abbe::testing {
namespace {

constexpr double kExact = 1e-12;
using Trouble = ToolVectors::Trouble;

Machine table(const std::string& range = "") {
  return plan_of("format = 1\n[machine]\nchain = \"w C A b X Y Z t\"\n[axis.A]\ndirection = [1, 0, 0]\n" +
                 range + "[axis.C]\ndirection = [0, 0, 1]\n")
      .machine();
}
Machine head() {
  return plan_of(
             "format = 1\n[machine]\nchain = \"w b X Y Z C B t\"\n[axis.B]\ndirection = [0, 1, 0]\n"
             "[axis.C]\ndirection = [0, 0, 1]\n")
      .machine();
}
ToolVectors vectors_of(const Machine& machine) { return {machine, addressed_axes(machine)}; }
Turns degrees(double a, double b, double c) { return {a * deg, b * deg, c * deg}; }

// The table A leans the work by a, the tool leans the other way: v = (sin c sin a, cos c sin a, cos a).
TEST(ToolVectors, OfATiltingTableAreWhatTheDrawingSays) {
  const ToolVectors vectors = vectors_of(table());
  const Vec3 v = vectors.vector_of(degrees(30, 0, 40));
  const double a = 30 * deg, c = 40 * deg;
  EXPECT_NEAR(v.x(), std::sin(c) * std::sin(a), kExact);
  EXPECT_NEAR(v.y(), std::cos(c) * std::sin(a), kExact);
  EXPECT_NEAR(v.z(), std::cos(a), kExact);
}

// A head B leans the tool's spindle towards +X: v = (cos c sin b, sin c sin b, cos b).
TEST(ToolVectors, OfAHeadAreWhatTheDrawingSays) {
  const ToolVectors vectors = vectors_of(head());
  const double b = 25 * deg, c = -70 * deg;
  const Vec3 v = vectors.vector_of({0, b, c});
  EXPECT_NEAR(v.x(), std::cos(c) * std::sin(b), kExact);
  EXPECT_NEAR(v.y(), std::sin(c) * std::sin(b), kExact);
  EXPECT_NEAR(v.z(), std::cos(b), kExact);
}

TEST(ToolVectors, TheVectorOfItsTurnsLeadsBack) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> tilt(5, 80), turn(-500, 500), step(-20, 20), size(0.1, 30);
  for (const Machine& machine : {table(), head()}) {
    const ToolVectors vectors = vectors_of(machine);
    for (int i = 0; i < 500; ++i) {
      const double t = tilt(random), c = turn(random);
      const Turns meant = degrees(t, t, c), from = degrees(t + step(random) / 5, t, c + step(random));
      const auto found = vectors.turns_of(size(random) * vectors.vector_of(meant), from);
      ASSERT_EQ(found.trouble, Trouble::none) << t << " " << c;
      EXPECT_LT((vectors.vector_of(found.turns) - vectors.vector_of(meant)).norm(), kExact * 100);
      EXPECT_NEAR(found.turns[2], meant[2], 1e-9) << "counted through whole turns";
    }
  }
}

TEST(ToolVectors, NearestIsNearInBothAxes) {
  const ToolVectors vectors = vectors_of(table());
  const Vec3 v = vectors.vector_of(degrees(30, 0, 10));  // also A-30 C190
  EXPECT_NEAR(vectors.turns_of(v, degrees(25, 0, 0)).turns[0] / deg, 30, 1e-9);
  EXPECT_NEAR(vectors.turns_of(v, degrees(-25, 0, 200)).turns[0] / deg, -30, 1e-9);
  EXPECT_NEAR(vectors.turns_of(v, degrees(-25, 0, 200)).turns[2] / deg, 190, 1e-9);
  EXPECT_EQ(vectors.turns_of(v, degrees(5, 0, 150)).trouble, Trouble::several)
      << "A is nearer to 30, C to 190";
  EXPECT_EQ(vectors_of(table("range = [-5, 100]\n")).turns_of(v, degrees(5, 0, 150)).trouble, Trouble::none);
  EXPECT_EQ(vectors_of(table("range = [-5, 20]\n")).turns_of(v, degrees(5, 0, 0)).trouble, Trouble::travel);
}

TEST(ToolVectors, TheOuterAxisStaysAtThePole) {
  const ToolVectors vectors = vectors_of(table());
  const auto found = vectors.turns_of(Vec3::UnitZ(), degrees(20, 0, 77));
  ASSERT_EQ(found.trouble, Trouble::none);
  EXPECT_NEAR(found.turns[0], 0, kExact);
  EXPECT_NEAR(found.turns[2] / deg, 77, 1e-9);
  EXPECT_EQ(vectors.turns_of(Vec3(0, 1e-5, 1), degrees(0, 0, 77)).trouble, Trouble::pole)
      << "a hair's breadth of tilt would turn C by 77 degrees";
}

TEST(ToolVectors, WhatNoAxesGiveIsRefused) {
  const Machine leaning = plan_of(
                              "format = 1\n[machine]\nchain = \"w C A b X Y Z t\"\n[axis.A]\ndirection = "
                              "[0, 1, 1]\n[axis.C]\ndirection = [0, 0, 1]\n")
                              .machine();
  EXPECT_EQ(vectors_of(leaning).turns_of(-Vec3::UnitZ(), {}).trouble, Trouble::unreachable);
  EXPECT_EQ(vectors_of(table()).turns_of(Vec3::Zero(), {}).trouble, Trouble::axes);
  EXPECT_EQ(vectors_of(table()).turns_of(Vec3(std::nan(""), 0, 1), {}).trouble, Trouble::axes);
  const Machine one =
      plan_of("format = 1\n[machine]\nchain = \"w A b X Y Z t\"\n[axis.A]\ndirection = [1, 0, 0]\n")
          .machine();
  EXPECT_EQ(vectors_of(one).turns_of(Vec3::UnitZ(), {}).trouble, Trouble::axes);
}

}  // namespace
}  // namespace abbe::testing
