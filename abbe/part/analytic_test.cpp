// Surfaces with known answers, cut along their tool paths: what a perfect machine leaves, what single errors
// do.

#include <gtest/gtest.h>

#include <cmath>

#include "abbe/part/machined_surface.h"
#include "abbe/surface/test_surfaces.h"
#include "abbe/surface/tool_path.h"

namespace abbe {
namespace {

const Cutter kBall{3, 3, 30};
constexpr double kScallop = 10 * um, kChord = 1 * um, kReach = 1;
constexpr double kSlack = 0.05 * um;  // of the scallop: that of two passes is taken at their middle

/// The pieces of a tool path, tips moved by error(tip).
template <class Error>
MachinedSurface cut(const NurbsSurface& surface, const Error& error) {
  ToolPathJob job;
  job.scallop = kScallop;
  job.tolerance = kChord;
  const auto made = make_tool_path(NearestPoint(surface), job);
  std::vector<SweepPiece> pieces;
  const auto pose = [&](const Vec3& tip) { return ToolPose{tip + error(tip), Vec3::UnitZ()}; };
  Vec3 last = Vec3::Zero();
  for (const ToolPass& pass : std::get<ToolPath>(made).passes) {
    for (std::size_t k = 0; k < pass.points.size(); ++k) {
      if (k > 0 || pass.linked) pieces.push_back({pose(last), pose(pass.points[k].tip), 0});
      last = pass.points[k].tip;
    }
  }
  return MachinedSurface(kBall, std::move(pieces));
}

Vec3 no_error(const Vec3&) { return Vec3::Zero(); }

struct Shape {
  const char* name;
  NurbsSurface surface;
};
std::vector<Shape> shapes() {
  return {{"plane", plane_patch(15, 12, 0.3, -0.2)},
          {"trough", cylinder_patch(12, 0.6, 12, true)},
          {"hump", cylinder_patch(12, 0.6, 12, false)},
          {"hollow sphere", sphere_patch(20, 0.2, 0.7, 0.8, true)},
          {"sphere", sphere_patch(20, 0.2, 0.7, 0.8, false)}};
}

double at(const MachinedSurface& part, const SurfacePoint& s) {
  const auto d = part.deviation(s.p, s.normal, kReach);
  EXPECT_TRUE(d);
  return d.value_or(99);
}

TEST(Analytic, APerfectMachineLeavesTheScallopAndNothingElse) {
  for (const Shape& shape : shapes()) {
    const MachinedSurface part = cut(shape.surface, no_error);
    double least = 1, most = -1;
    for (const SurfacePlace& place : cell_places(shape.surface, 101, 13)) {
      const double d = at(part, evaluate(shape.surface, place));
      least = std::min(least, d);
      most = std::max(most, d);
    }
    EXPECT_GE(least, -kChord) << shape.name;
    EXPECT_LE(most, kScallop + kChord + kSlack) << shape.name;
    EXPECT_GE(most, 0.9 * kScallop) << shape.name;
  }
}

TEST(Analytic, AConstantErrorIsItsNormalPart) {
  // d' - d = n . e, up to the change of the scallop, e^2 / 2R and the shift along it: e * its slope (0.08)
  const Vec3 e(4 * um, -3 * um, 5 * um);
  for (const Shape& shape : shapes()) {
    const MachinedSurface part = cut(shape.surface, no_error),
                          moved = cut(shape.surface, [&](const Vec3&) { return e; });
    for (const SurfacePlace& place : cell_places(shape.surface, 7, 7)) {
      const SurfacePoint s = evaluate(shape.surface, place);
      EXPECT_NEAR(at(moved, s) - at(part, s), s.normal.dot(e), 0.09 * e.norm()) << shape.name;
      EXPECT_NEAR(*moved.deviation(s.p + e, s.normal, kReach), at(part, s), 1e-9)
          << "the part moves as a whole";
    }
  }
}

TEST(Analytic, SquarenessShearsThePart) {
  // Z leans by 1 mrad towards +X: e = (1e-3 z, 0, 0) of the tip; n.e with the tip's z, R (1 - n.z) below the
  // centre
  const auto shear = [](const Vec3& tip) { return Vec3(1e-3 * tip.z(), 0, 0); };
  for (const Shape& shape : shapes()) {
    const MachinedSurface part = cut(shape.surface, no_error), sheared = cut(shape.surface, shear);
    double effect = 0;
    for (const SurfacePlace& place : cell_places(shape.surface, 7, 7)) {
      const SurfacePoint s = evaluate(shape.surface, place);
      const double z = s.p.z() + kBall.radius * (s.normal.z() - 1), is = at(sheared, s) - at(part, s);
      const double size = std::abs(1e-3 * z);
      EXPECT_NEAR(is, s.normal.x() * 1e-3 * z, 0.12 * size + 0.3 * um) << shape.name;
      effect += is * s.normal.x() * z;
    }
    EXPECT_GT(effect, 0) << "the wrong sign would be negative: " << shape.name;
  }
}

TEST(Analytic, MirroredErrorsMakeMirroredParts) {
  // The hump is the same seen from +x and from -x; so is its part if the error is mirrored, too.
  const NurbsSurface hump = cylinder_patch(12, 0.6, 12, false);
  const auto right = [](const Vec3& tip) { return Vec3(0, 0, 5e-3 * tip.x()); };
  const auto left = [](const Vec3& tip) { return Vec3(0, 0, -5e-3 * tip.x()); };
  const MachinedSurface a = cut(hump, right), b = cut(hump, left);
  double apart = 0;  // of parts that are not mirrored
  for (const SurfacePlace& place : cell_places(hump, 9, 5)) {
    const SurfacePoint s = evaluate(hump, place), m = evaluate(hump, {1 - place.u, place.v});
    // Passes do not mirror exactly (the last step is what is left), so scallops differ.
    EXPECT_NEAR(at(a, s), at(b, m), kScallop + kChord);
    apart = std::max(apart, std::abs(at(a, s) - at(a, m)));
  }
  EXPECT_GT(apart, 3 * (kScallop + kChord)) << "the error must show";
}

TEST(Analytic, WornCuttersLeaveTheirWear) {
  std::vector<SweepPiece> pieces;
  for (double y = 0; y < 12; y += 1)
    pieces.push_back({{Vec3(0, y, -12), Vec3::UnitZ()}, {Vec3(0, y + 1, -12), Vec3::UnitZ()}, 4 * um});
  const MachinedSurface worn(kBall, pieces);
  EXPECT_NEAR(*worn.deviation(Vec3(0, 6, -12), Vec3::UnitZ(), kReach), 4 * um, 1e-12);
}

}  // namespace
}  // namespace abbe
