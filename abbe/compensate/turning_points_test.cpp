#include "abbe/compensate/turning_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "abbe/core/units.h"

namespace abbe {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kExact = 1e-12;
constexpr double kLeast = 1e-4;  // mm

/// Counter-clockwise about the origin, radius 10, `from` and `sweep` in degrees.
Arc arc(double from, double sweep, Plane plane = Plane::xy) {
  Arc arc;
  arc.plane = plane;
  arc.r0 = arc.r1 = 10;
  arc.a0 = from * deg;
  arc.sweep = sweep * deg;
  return arc;
}

TEST(TurningPoints, AreTheQuarters) {
  EXPECT_THAT(turning_points(arc(45, 180), 0, kLeast),
              ElementsAre(DoubleNear(0.25, kExact), DoubleNear(0.75, kExact)));
  EXPECT_THAT(turning_points(arc(45, -180), 0, kLeast),
              ElementsAre(DoubleNear(0.25, kExact), DoubleNear(0.75, kExact)));
  EXPECT_THAT(turning_points(arc(10, 60), 0, kLeast), IsEmpty());
  EXPECT_EQ(turning_points(arc(45, 3600), 0, kLeast).size(), 40u);
}

TEST(TurningPoints, EndsThatLieOnAQuarterAreNone) {
  EXPECT_THAT(turning_points(arc(0, 90), 0, kLeast), IsEmpty());
  // 0.02 degrees before the quarter X has 0.6 nm to go
  EXPECT_THAT(turning_points(arc(-0.02, 90.04), 0, kLeast), IsEmpty());
  EXPECT_EQ(turning_points(arc(-1, 92), 0, kLeast).size(), 2u);
}

TEST(TurningPoints, TurnWithARotatedWorkOffset) {
  EXPECT_THAT(turning_points(arc(45, 90), 30 * deg, kLeast), ElementsAre(DoubleNear(15.0 / 90, kExact)));
  EXPECT_THAT(turning_points(arc(45, 90, Plane::zx), 30 * deg, kLeast), ElementsAre(DoubleNear(0.5, kExact)));
}

TEST(TurningPoints, OfASpiralAreWhereTheDerivativeIsZero) {
  Arc spiral = arc(45, 180);
  spiral.r1 = 10.5;
  const auto places = turning_points(spiral, 0, kLeast);
  ASSERT_EQ(places.size(), 2u);
  EXPECT_NEAR(spiral.direction(places[0]).y(), 0, 1e-6);
  EXPECT_NEAR(spiral.direction(places[1]).x(), 0, 1e-6);
}

}  // namespace
}  // namespace abbe
