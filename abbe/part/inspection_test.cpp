#include "abbe/part/inspection.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "abbe/surface/test_surfaces.h"

namespace abbe {
namespace {

constexpr double kFit = 1e-8;  // mm: after the last round of a fit

std::vector<TouchedPoint> points_of(const NurbsSurface& surface, std::size_t n) {
  std::vector<TouchedPoint> out;
  for (const SurfacePlace& place : cell_places(surface, n, n))
    out.push_back({evaluate(surface, place).p, place});
  return out;
}

TEST(Inspection, PointsOnTheSurfaceHaveNoDeviation) {
  const NearestPoint nominal(wavy_patch(4));
  const Inspection is = inspect_points(nominal, points_of(nominal.surface(), 10), BestFit::none);
  EXPECT_EQ(is.figures.count, 100u);
  EXPECT_LT(is.figures.profile, kFit);
  EXPECT_LT(is.figures.linear, kFit);
}

TEST(Inspection, DeviationIsAlongTheNormal) {
  const NearestPoint nominal(wavy_patch(4));
  std::vector<TouchedPoint> points = points_of(nominal.surface(), 4);
  for (std::size_t k = 0; k < points.size(); ++k)
    points[k].measured += (k == 3 ? -0.02 : 0.005) * evaluate(nominal.surface(), *points[k].target).normal;
  for (const bool known : {true, false}) {
    if (!known) {
      for (TouchedPoint& point : points) point.target.reset();
    }
    const InspectionFigures is = inspect_points(nominal, points, BestFit::none).figures;
    EXPECT_NEAR(is.least, -0.02, kFit) << "-: too much is cut";
    EXPECT_NEAR(is.most, 0.005, kFit);
    EXPECT_NEAR(is.profile, 0.04, kFit);
    EXPECT_NEAR(is.range, 0.025, kFit);
    EXPECT_NEAR(is.linear, (15 * 0.005 + 0.02) / 16, kFit);
    EXPECT_NEAR(is.mean, (15 * 0.005 - 0.02) / 16, kFit);
  }
}

TEST(Inspection, AMovedPartFitsBack) {
  const NearestPoint nominal(wavy_patch(9));
  const Vec3 turn(1e-3, -2e-3, 1.5e-3), shift(0.05, -0.08, 0.1);
  std::vector<TouchedPoint> points = points_of(nominal.surface(), 10);
  Vec3 centre = Vec3::Zero();
  for (const TouchedPoint& point : points) centre += point.measured / 100;
  const Mat3 R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  for (TouchedPoint& point : points) {
    point.measured = R * (point.measured - centre) + centre + shift;
    point.target.reset();
  }
  EXPECT_GT(inspect_points(nominal, points, BestFit::none).figures.profile, 0.1);
  const Inspection is = inspect_points(nominal, points, BestFit::rigid, 1);
  EXPECT_TRUE(is.settled);
  EXPECT_EQ(is.rank, 6);
  EXPECT_LT(is.figures.profile, kFit);
  EXPECT_LT((is.turn + turn).norm(), 1e-8) << "the fit turns back";
  EXPECT_LT((is.shift + shift).norm(), 1e-6);
}

TEST(Inspection, APlaneTellsThreeMotions) {
  const NearestPoint nominal(plane_patch(80, 60));
  std::vector<TouchedPoint> points = points_of(nominal.surface(), 6);
  for (TouchedPoint& point : points)
    point.measured.z() += 0.01 + 1e-4 * point.measured.x() - 5e-5 * point.measured.y();
  const Inspection is = inspect_points(nominal, points, BestFit::rigid, 1);
  EXPECT_EQ(is.rank, 3);
  EXPECT_LT(is.figures.profile, 1e-7);
  EXPECT_LT(std::hypot(is.shift.x(), is.shift.y()), 1e-6) << "what the points do not tell stays";
  // Shift alone cannot take the tilt away.
  const Inspection shifted = inspect_points(nominal, points, BestFit::shift, 1);
  EXPECT_NEAR(shifted.figures.mean, 0, 1e-9);
  EXPECT_GT(shifted.figures.range, 5e-3);
}

TEST(Inspection, PointsBesideThePatchDoNotCount) {
  const NearestPoint nominal(plane_patch(80, 60));
  std::vector<TouchedPoint> points = {
      {Vec3(10, 10, 0.001), {}}, {Vec3(90, 10, 0.5), {}}, {Vec3(80.05, 10, 0.002), {}}};
  const InspectionFigures is = inspect_points(nominal, points, BestFit::none).figures;
  EXPECT_EQ(is.count, 2u);
  EXPECT_EQ(is.beside, 1u);
  EXPECT_NEAR(is.most, 0.002, kFit);
  EXPECT_EQ(inspect_points(nominal, {}, BestFit::rigid).figures.count, 0u);
}

TEST(Inspection, APoleCounts) {
  const NearestPoint nominal(sphere_patch(25, 0, 1.1, 1.4, false));
  const InspectionFigures is = inspect_points(nominal, {{Vec3(0, 0, 25.05), {}}}, BestFit::none).figures;
  EXPECT_EQ(is.count, 1u);
  EXPECT_NEAR(is.most, 0.05, kFit);
}

TEST(Inspection, ACreasedFitComesToRest) {
  // Both faces and a point above the ridge: moved, and found back.
  const NearestPoint nominal(roof_patch(false));
  std::vector<TouchedPoint> points = points_of(nominal.surface(), 8);
  points.push_back({Vec3(0, 10, 0), {}});
  const Vec3 moved(0.02, 0, 0.03);
  for (TouchedPoint& point : points) point = {point.measured + moved, {}};
  EXPECT_EQ(inspect_points(nominal, points, BestFit::none).figures.creased, 1u);
  const Inspection is = inspect_points(nominal, points, BestFit::shift);
  EXPECT_TRUE(is.settled);
  EXPECT_EQ(is.rank, 2) << "nothing along the ridge";
  EXPECT_LT((is.shift + moved).norm(), kFit);
}

TEST(Inspection, StopsWhenAsked) {
  const NearestPoint nominal(plane_patch(80, 60));
  const std::vector<TouchedPoint> points = points_of(nominal.surface(), 40);
  std::uint64_t most = 0;
  const auto go_on = [&](std::uint64_t done, std::uint64_t) { return (most = done) < 500; };
  EXPECT_TRUE(inspect_points(nominal, points, BestFit::rigid, 0.1, go_on).stopped);
  EXPECT_LT(most, 1000u);
  const auto never = [](std::uint64_t, std::uint64_t) { return true; };
  EXPECT_FALSE(inspect_points(nominal, points, BestFit::rigid, 0.1, never).stopped);
}

}  // namespace
}  // namespace abbe
