#include "abbe/compensate/arc.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "abbe/core/units.h"

namespace abbe {
namespace {

constexpr double kPicometre = 1e-9;

TEST(Arc, PassesThroughItsEndsInEveryPlane) {
  std::mt19937_64 rng{5};
  std::uniform_real_distribution<double> coordinate(-100, 100), angle(0, 2 * std::numbers::pi);
  for (int k = 0; k < 1000; ++k) {
    const Plane plane = static_cast<Plane>(k % 3);
    const auto [a, b, n] = plane_axes(plane);
    Vec3 start, end;
    const double ca = coordinate(rng), cb = coordinate(rng), r = 1 + std::abs(coordinate(rng)),
                 t0 = angle(rng), t1 = angle(rng);
    start[a] = ca + r * std::cos(t0), start[b] = cb + r * std::sin(t0), start[n] = coordinate(rng);
    end[a] = ca + r * std::cos(t1), end[b] = cb + r * std::sin(t1), end[n] = coordinate(rng);
    const bool clockwise = rng() % 2 == 0;
    const auto arc = arc_about(plane, start, end, ca, cb, clockwise, 1);
    ASSERT_TRUE(arc);
    EXPECT_LT((arc->at(0) - start).norm(), kPicometre);
    EXPECT_LT((arc->at(1) - end).norm(), kPicometre);
    EXPECT_EQ(arc->sweep < 0, clockwise);
  }
}

TEST(Arc, CounterClockwiseTurnsFromTheFirstAxisToTheSecond) {
  // G3 in G18 turns from Z to X
  const auto arc = arc_about(Plane::zx, {0, 0, 10}, {10, 0, 0}, 0, 0, false, 1);
  ASSERT_TRUE(arc);
  EXPECT_NEAR(arc->sweep, std::numbers::pi / 2, 1e-12);
}

TEST(Arc, TurnsAddFullCircles) {
  const auto arc = arc_about(Plane::xy, {10, 0, 0}, {10, 0, 5}, 0, 0, true, 3);
  ASSERT_TRUE(arc);
  EXPECT_NEAR(arc->sweep, -6 * std::numbers::pi, 1e-12);
}

TEST(Arc, RadiusFormTakesTheShorterArcForAPositiveRadius) {
  for (const bool clockwise : {false, true}) {
    for (const double r : {7.0, -7.0}) {
      const Vec3 start(1, 2, 0), end(6, 5, 0);
      const auto centre = centre_of_radius(Plane::xy, start, end, r, clockwise);
      ASSERT_TRUE(centre);
      const auto arc = arc_about(Plane::xy, start, end, centre->a, centre->b, clockwise, 1);
      EXPECT_NEAR(arc->r0, 7, kPicometre);
      EXPECT_EQ(std::abs(arc->sweep) < std::numbers::pi, r > 0) << clockwise << r;
    }
  }
}

// A circle moved, stretched and tilted by less than the fit can follow: the centre is found again.
TEST(FitCentre, FollowsAShiftedAndGrownArc) {
  std::mt19937_64 rng{9};
  std::uniform_real_distribution<double> shift(-0.05, 0.05), sweep(0.3, 6.0), first(0, 6.28);
  for (int k = 0; k < 200; ++k) {
    Arc nominal;
    nominal.centre_a = 3, nominal.centre_b = -4, nominal.r0 = nominal.r1 = 25, nominal.a0 = first(rng),
    nominal.sweep = sweep(rng);
    Arc moved = nominal;
    moved.centre_a += shift(rng), moved.centre_b += shift(rng);
    const double growth = shift(rng);
    moved.r0 += growth, moved.r1 += growth;
    std::vector<ArcTarget> targets;
    for (int i = 1; i <= 12; ++i) targets.push_back({i / 12.0, moved.at(i / 12.0)});
    const Centre centre = fit_centre(nominal, moved.at(0), moved.at(1), targets);
    Arc fitted = *arc_about(Plane::xy, moved.at(0), moved.at(1), centre.a, centre.b, false, 1);
    EXPECT_LT(distance_to(fitted, targets), 0.05 * um) << nominal.sweep;
  }
}

}  // namespace
}  // namespace abbe
