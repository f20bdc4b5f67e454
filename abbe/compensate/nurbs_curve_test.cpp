#include "abbe/compensate/nurbs_curve.h"

#include <gtest/gtest.h>

#include <cmath>

namespace abbe {
namespace {

constexpr double kExact = 1e-12;

NurbsCurve cubic() {
  return {4,
          {0, 0, 0, 0, 1, 2.5, 3, 3, 3, 3},
          {1, 2, 0.5, 1, 1, 3},
          {{0, 0, 0}, {10, 30, 1}, {40, 35, 2}, {60, -10, 0}, {90, 5, -3}, {100, 0, 0}}};
}

// A quarter of the unit circle: points (1,0) (1,1) (0,1), weights 1, 1/sqrt 2, 1; its middle is at 45
// degrees.
TEST(NurbsCurve, IsACircleWithTheseWeights) {
  const NurbsCurve circle{3, {0, 0, 0, 1, 1, 1}, {1, std::sqrt(0.5), 1}, {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  ASSERT_EQ(fault_of(circle), "");
  EXPECT_NEAR(place_on(circle, 0.5).x(), std::sqrt(0.5), kExact);
  EXPECT_NEAR(place_on(circle, 0.5).y(), std::sqrt(0.5), kExact);
  for (const double u : {0.0, 0.1, 0.37, 0.9, 1.0}) EXPECT_NEAR(place_on(circle, u).norm(), 1, kExact);
}

// Bernstein at 1/4: 27/64 27/64 9/64 1/64 of (0,0) (0,64) (64,64) (64,0): x = 9 + 1, y = 27 + 9
TEST(NurbsCurve, IsABezierCurveWithoutInnerKnots) {
  const NurbsCurve bezier{
      4, {0, 0, 0, 0, 1, 1, 1, 1}, {1, 1, 1, 1}, {{0, 0, 0}, {0, 64, 0}, {64, 64, 0}, {64, 0, 0}}};
  EXPECT_NEAR((place_on(bezier, 0.25) - Vec3(10, 36, 0)).norm(), 0, kExact);
  EXPECT_NEAR(greville(bezier, 1), 1.0 / 3, kExact);
}

TEST(NurbsCurve, ItBeginsAndEndsAtItsPoints) {
  const NurbsCurve curve = cubic();
  ASSERT_EQ(fault_of(curve), "");
  EXPECT_NEAR((place_on(curve, 0) - curve.points.front()).norm(), 0, kExact);
  EXPECT_NEAR((place_on(curve, 3) - curve.points.back()).norm(), 0, kExact);
  EXPECT_EQ(greville(curve, 0), 0);
  EXPECT_NEAR(greville(curve, 3), (1 + 2.5 + 3) / 3, kExact);
  EXPECT_EQ(greville(curve, 5), 3);
}

// c(x) = M x + t: every control point by its own c
TEST(NurbsCurve, AnAffineMovementIsExact) {
  const NurbsCurve curve = cubic();
  Mat3 M;
  M << 1e-4, -5e-5, 0, 2e-5, 3e-5, 1e-5, 0, 4e-5, -2e-5;
  const Vec3 t(0.01, -0.02, 0.005);
  std::vector<Vec3> wanted;
  for (std::size_t i = 0; i < curve.points.size(); ++i)
    wanted.push_back(M * place_on(curve, greville(curve, i)) + t);
  const std::vector<Vec3> shifts = shifts_through(curve, wanted);
  constexpr double kFewNanometres = 1e-5;
  for (std::size_t i = 0; i < shifts.size(); ++i)
    EXPECT_NEAR((shifts[i] - (M * curve.points[i] + t)).norm(), 0, kFewNanometres) << i;
}

TEST(NurbsCurve, WhatIsNoneSaysWhy) {
  const auto broken = [](const auto& change) {
    NurbsCurve curve = cubic();
    change(curve);
    return !fault_of(curve).empty();
  };
  EXPECT_TRUE(broken([](NurbsCurve& c) { c.knots.pop_back(); }));
  EXPECT_TRUE(broken([](NurbsCurve& c) { c.knots[4] = 2.9; }));
  EXPECT_TRUE(broken([](NurbsCurve& c) { c.knots[0] = -1; }));
  EXPECT_TRUE(broken([](NurbsCurve& c) { c.weights[2] = 0; }));
  EXPECT_TRUE(broken([](NurbsCurve& c) { c.order = 1; }));
  EXPECT_TRUE(broken([](NurbsCurve& c) { c.order = 7; }));
  EXPECT_TRUE(broken([](NurbsCurve& c) { c.knots[5] = std::nan(""); }));
}

}  // namespace
}  // namespace abbe
