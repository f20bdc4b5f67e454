#include "abbe/surface/nurbs.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "abbe/surface/nearest.h"
#include "abbe/surface/surface_check.h"
#include "abbe/surface/test_surfaces.h"

namespace abbe {
namespace {

constexpr double kRounding = 1e-12;   // mm
constexpr double kCrease = 1e-8;      // mm: Newton goes to a kink in halves
constexpr double kDifference = 2e-6;  // of central differences with a step of 1e-4, relative to their size

TEST(Nurbs, DerivativesAreDifferenceQuotients) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const NurbsSurface s = wavy_patch(seed);
    ASSERT_TRUE(s.is_valid());
    constexpr double h = 1e-4;
    const double u = 0.11 + 0.037 * seed, v = 0.93 - 0.041 * seed;
    const SurfacePoint at = evaluate(s, {u, v});
    const SurfacePoint ul = evaluate(s, {u - h, v}), uh = evaluate(s, {u + h, v});
    const SurfacePoint vl = evaluate(s, {u, v - h}), vh = evaluate(s, {u, v + h});
    const auto near = [&](const Vec3& is, const Vec3& difference, const char* name) {
      EXPECT_LT((is - difference / (2 * h)).norm(), kDifference * (1 + is.norm()))
          << name << " seed " << seed;
    };
    near(at.u, uh.p - ul.p, "u");
    near(at.v, vh.p - vl.p, "v");
    near(at.uu, uh.u - ul.u, "uu");
    near(at.uv, vh.u - vl.u, "uv");
    near(at.vv, vh.v - vl.v, "vv");
    EXPECT_GT(at.normal.z(), 0.2);
  }
}

TEST(Nurbs, CornersAreCornerPoints) {
  const NurbsSurface s = wavy_patch(3);
  EXPECT_LT((evaluate(s, {0, 0}).p - s.points.front()).norm(), kRounding);
  EXPECT_LT((evaluate(s, {1, 1}).p - s.points.back()).norm(), kRounding);
  EXPECT_LT((evaluate(s, {7, -2}).p - evaluate(s, {1, 0}).p).norm(), kRounding) << "outside: the border";
}

TEST(Nurbs, SphereAndCylinderAreExact) {
  for (const bool hollow : {false, true}) {
    const NurbsSurface sphere = sphere_patch(25, 0.3, 1.1, 1.4, hollow);
    const NurbsSurface trough = cylinder_patch(12, 0.9, 40, hollow);
    const double bend = hollow ? 1 : -1;  // a hollow bends towards its outward normal
    for (const SurfacePlace& place : cell_places(sphere, 5, 7)) {
      const SurfacePoint s = evaluate(sphere, place);
      EXPECT_NEAR(s.p.norm(), 25, kRounding);
      EXPECT_LT((s.normal + bend * s.p / 25).norm(), kRounding);
      EXPECT_NEAR(curvature_at(s).least, bend / 25, 1e-8);
      EXPECT_NEAR(curvature_at(s).most, bend / 25, 1e-8);
      const SurfacePoint c = evaluate(trough, place);
      EXPECT_NEAR(std::hypot(c.p.x(), c.p.z()), 12, kRounding);
      EXPECT_GT(c.normal.z(), 0);
      EXPECT_NEAR(curvature_along(c, c.u), bend / 12, 1e-10);
      EXPECT_NEAR(curvature_along(c, c.v), 0, 1e-10);
      EXPECT_NEAR(curvature_at(c).gauss(), 0, 1e-10);
      // k(d) between both: Euler's cos^2
      EXPECT_NEAR(curvature_along(c, c.u.normalized() + c.v.normalized()), bend / 24, 1e-10);
    }
  }
}

TEST(Nurbs, AffineMapsOfThePointsMapTheSurface) {
  const NurbsSurface s = wavy_patch(5);
  NurbsSurface moved = s;
  const Mat3 R = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Vec3& p : moved.points) p = R * p + Vec3(3, -8, 11);
  for (const SurfacePlace& place : cell_places(s, 4, 4)) {
    const SurfacePoint a = evaluate(s, place), b = evaluate(moved, place);
    EXPECT_LT((R * a.p + Vec3(3, -8, 11) - b.p).norm(), 1e-11);
    EXPECT_LT((R * a.normal - b.normal).norm(), 1e-11);
    EXPECT_NEAR(curvature_at(a).most, curvature_at(b).most, 1e-10);
  }
}

TEST(Nurbs, APoleHasTheNormalBesideIt) {
  for (const bool hollow : {true, false}) {
    // The pole at the lower and at the upper end of u.
    for (const auto& [from, to, pole] : {std::array{0.0, 1.1, 0.0}, std::array{-1.1, 0.0, 1.0}}) {
      const NurbsSurface sphere = sphere_patch(10, from, to, 1.4, hollow);
      for (const double v : {0.0, 0.3, 1.0}) {
        const SurfacePoint at = evaluate(sphere, {pole, v}),
                           near = evaluate(sphere, {0.999 * pole + 5e-4, v});
        EXPECT_TRUE(at.is_pole());
        EXPECT_FALSE(near.is_pole());
        ASSERT_TRUE(at.is_regular());
        EXPECT_LT((at.normal - near.normal).norm(), 1e-3);
        EXPECT_NEAR(std::abs(at.normal.z()), 1, kRounding);
      }
    }
  }
}

TEST(Nearest, APoleIsAFoot) {
  const NearestPoint nearest(sphere_patch(25, 0, 1.1, 1.4, false));
  const SurfaceFoot foot = nearest({0, 0, 25.05});
  EXPECT_NEAR(foot.deviation, 0.05, kRounding);
  EXPECT_TRUE(foot.is_normal);
}

TEST(Nearest, BesideACreaseTheDeviationIsTheDistance) {
  const NearestPoint ridge(roof_patch(false)), valley(roof_patch(true));
  for (const double x : {-0.1, 0.0, 0.2}) {
    const SurfaceFoot above = ridge({x, 7, 0.3});
    EXPECT_NEAR(above.deviation, std::hypot(x, 0.3), kCrease);
    EXPECT_FALSE(above.is_normal);
    EXPECT_FALSE(above.on_rim);
    const SurfaceFoot below = valley({x, 7, -0.3});
    EXPECT_NEAR(below.deviation, -std::hypot(x, 0.3), kCrease);
    // On the other side a face is nearer than the crease.
    EXPECT_NEAR(ridge({x, 7, -0.3}).deviation, -(0.3 - std::abs(x)) / std::sqrt(2.0), kRounding);
    EXPECT_TRUE(ridge({x, 7, -0.3}).is_normal);
  }
}

TEST(Nearest, FootOfAPointOnTheNormalIsItsBase) {
  const NearestPoint nearest(wavy_patch(7));
  for (const SurfacePlace& place : cell_places(nearest.surface(), 9, 9)) {
    const SurfacePoint s = evaluate(nearest.surface(), place);
    for (const double height : {-0.5, -1e-4, 0.0, 2e-3, 1.5}) {
      const SurfaceFoot foot = nearest(s.p + height * s.normal);
      EXPECT_NEAR(foot.deviation, height, kRounding);
      EXPECT_LT((foot.at.p - s.p).norm(), 1e-6);
      EXPECT_FALSE(foot.on_rim);
    }
  }
}

TEST(Nearest, NoSampleIsNearer) {
  const NearestPoint nearest(wavy_patch(11));
  const std::vector<SurfacePlace> places = cell_places(nearest.surface(), 60, 60);
  for (int k = 0; k < 60; ++k) {
    const Vec3 point(-10 + 1.4 * k, 70 - 1.3 * k, -6 + 0.37 * k);
    const SurfaceFoot foot = nearest(point);
    for (const SurfacePlace& place : places)
      ASSERT_LE(foot.distance, (evaluate(nearest.surface(), place).p - point).norm() + kRounding) << k;
  }
}

TEST(Nearest, SphereGivesRadiusDifference) {
  const NearestPoint nearest(sphere_patch(25, 0.3, 1.1, 1.4, true));
  const Vec3 inside = evaluate(nearest.surface(), {0.4, 0.7}).p * (24.0 / 25);
  EXPECT_NEAR(nearest(inside).deviation, 1, kRounding) << "material left in the hollow";
  EXPECT_NEAR(nearest(inside * (25.5 / 24)).deviation, -0.5, kRounding);
  const SurfaceFoot off = nearest({60, 60, 0});
  EXPECT_TRUE(off.on_rim);
  EXPECT_GT(off.distance, std::abs(off.deviation));
}

TEST(SurfaceCheck, AFlatPatchIsSound) {
  EXPECT_FALSE(find_fault(plane_patch(80, 80)));
  EXPECT_FALSE(find_fault(sphere_patch(25, 0.3, 1.1, 1.4, true)));
  for (unsigned seed = 1; seed < 6; ++seed) EXPECT_FALSE(find_fault(wavy_patch(seed))) << seed;
}

TEST(SurfaceCheck, ACrossingIsFound) {
  // A strip that goes round a loop and through itself; it leans, so that it has a normal everywhere.
  NurbsSurface loop;
  loop.degree = {3, 1};
  loop.count = {4, 2};
  loop.knots = {uniform_knots(4, 3), uniform_knots(2, 1)};
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(30, 0, 30), Vec3(-20, 0, 30), Vec3(10, 0, 0)})
    for (const double y : {0.0, 10.0}) loop.points.push_back(p + Vec3(0, y, 0));
  loop.weights.assign(8, 1.0);
  const auto fault = find_fault(loop);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->kind, SurfaceFault::Kind::intersecting);
  EXPECT_NEAR(fault->place.u + fault->other.u, 1, 0.3) << "the loop is symmetric";
  EXPECT_NE(to_text(*fault).find("cuts itself"), std::string::npos);
}

TEST(SurfaceCheck, AFoldIsFound) {
  NurbsSurface fold = wavy_patch(1);
  for (std::size_t j = 0; j < 7; ++j) fold.points[2 * 7 + j].x() = 60;
  const auto fault = find_fault(fold);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->kind, SurfaceFault::Kind::folded);
  NurbsSurface line = plane_patch(10, 10);
  for (Vec3& p : line.points) p.y() = 0;
  ASSERT_TRUE(find_fault(line));
  EXPECT_EQ(find_fault(line)->kind, SurfaceFault::Kind::degenerate);
}

}  // namespace
}  // namespace abbe
