#include "abbe/part/machined_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "abbe/part/test_brute_force.h"

namespace abbe {
namespace {

constexpr double kPico = 1e-9;  // mm

/// Passes along x, `step` apart in y, tips at z = 0, moved by what `error` says of a tip.
template <class Error>
std::vector<SweepPiece> passes(double length, double width, double step, double piece, const Error& error) {
  std::vector<SweepPiece> out;
  for (int row = 0; row * step <= width; ++row) {
    const auto pose = [&](double x) {
      const Vec3 tip(x, row * step, 0);
      return ToolPose{tip + error(tip), Vec3::UnitZ()};
    };
    for (int k = 0; k * piece < length; ++k) out.push_back({pose(k * piece), pose((k + 1) * piece), 0});
  }
  return out;
}

const auto kNoError = [](const Vec3&) { return Vec3(Vec3::Zero()); };

TEST(MachinedSurface, APerfectBallLeavesTheKnownScallop) {
  const MachinedSurface part(Cutter{3, 3, 30}, passes(20, 10, 0.5, 1, kNoError));
  const double scallop = 3 - std::sqrt(9 - 0.25 * 0.25);  // R - sqrt(R^2 - (step / 2)^2)
  double most = 0;
  for (double x = 0.2; x < 20; x += 1.3) {
    for (double y = 0; y < 10; y += 0.05) {
      const auto d = part.deviation(Vec3(x, y, 0), Vec3::UnitZ(), 0.5);
      ASSERT_TRUE(d);
      const double off = std::abs(y - 0.5 * std::round(y / 0.5));
      EXPECT_NEAR(*d, 3 - std::sqrt(9 - off * off), kPico);
      most = std::max(most, *d);
    }
  }
  EXPECT_NEAR(most, scallop, kPico);
}

TEST(MachinedSurface, FlatAndBullNoseLeaveThePlane) {
  for (const Cutter& cutter : {Cutter{4, 0, 30}, Cutter{4, 1, 30}}) {
    const MachinedSurface part(cutter, passes(20, 10, 2, 5, kNoError));
    for (double y = 0; y < 10; y += 0.33)
      EXPECT_NEAR(part.deviation(Vec3(7, y, 0.01), Vec3::UnitZ(), 0.5).value(), -0.01, kPico);
  }
}

TEST(MachinedSurface, EqualsTheBruteForceReference) {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
  };
  const auto wave = [](const Vec3& tip) { return Vec3(0, 0, 0.3 * std::sin(tip.x()) * std::cos(tip.y())); };
  for (const Cutter& cutter : {Cutter{3, 3, 30}, Cutter{3, 0, 30}, Cutter{3, 1, 30}}) {
    const std::vector<SweepPiece> pieces = passes(8, 4, 0.8, 0.9, wave);
    const MachinedSurface part(cutter, pieces);
    for (int k = 0; k < 12; ++k) {
      const Ray ray{Vec3(uniform(0, 8), uniform(0, 4), uniform(-0.3, 0.3)),
                    Vec3(uniform(-0.4, 0.4), uniform(-0.4, 0.4), 1).normalized(), -1, 1};
      std::optional<double> should, all;
      for (const SweepPiece& piece : pieces) {
        const auto sampled = brute_force_entry(cutter, piece, ray, 40, 60);
        if (sampled && (!should || *sampled < *should)) should = sampled;
        const auto exact = entry_of(cutter, piece, ray);
        if (exact && (!all || *exact < *all)) all = exact;
      }
      const auto is = part.deviation(ray.p, ray.n, 1);
      ASSERT_TRUE(is && should && all);
      EXPECT_NEAR(*is, *all, 1e-8) << "the tree loses nothing";
      EXPECT_LE(*is, *should + kPico);
      EXPECT_GE(*is, *should - 0.03) << "poses are 0.02 mm apart";
    }
  }
}

TEST(MachinedSurface, AnErrorOfTheToolIsTheErrorOfThePlane) {
  // z raised by 10 um and a squareness of 50 urad of Z in X: flat plane, dz alone counts.
  const MachinedSurface raised(Cutter{3, 3, 30},
                               passes(20, 10, 0.5, 1, [](const Vec3&) { return Vec3(0, 0, 0.01); }));
  EXPECT_NEAR(*raised.deviation(Vec3(7, 3, 0), Vec3::UnitZ(), 1), 0.01, kPico) << "material is left on: +";
  const MachinedSurface shifted(Cutter{3, 3, 30},
                                passes(20, 10, 0.5, 1, [](const Vec3&) { return Vec3(0.01, 0, 0); }));
  EXPECT_NEAR(*shifted.deviation(Vec3(7, 3, 0), Vec3::UnitZ(), 1), 0, kPico);
}

TEST(MachinedSurface, MoreCuttingNeverAddsMaterial) {
  std::vector<SweepPiece> pieces = passes(20, 10, 0.7, 1, kNoError);
  const MachinedSurface before(Cutter{3, 3, 30}, pieces);
  for (const SweepPiece& piece :
       passes(20, 10, 1.1, 0.6, [](const Vec3& tip) { return Vec3(0, 0.1, 0.02 * std::sin(tip.x())); }))
    pieces.push_back(piece);
  const MachinedSurface after(Cutter{3, 3, 30}, pieces);
  for (double x = 1; x < 19; x += 0.77)
    for (double y = 1; y < 9; y += 0.83)
      EXPECT_LE(*after.deviation(Vec3(x, y, 0), Vec3::UnitZ(), 1),
                *before.deviation(Vec3(x, y, 0), Vec3::UnitZ(), 1));
}

TEST(MachinedSurface, WhatNothingReachesIsUncut) {
  const MachinedSurface part(Cutter{3, 3, 30}, passes(20, 10, 0.5, 1, kNoError));
  EXPECT_FALSE(part.deviation(Vec3(40, 5, 0), Vec3::UnitZ(), 1));
  EXPECT_FALSE(part.deviation(Vec3(10, 5, -3), Vec3::UnitZ(), 1));
  EXPECT_EQ(*part.deviation(Vec3(10, 5, 3), Vec3::UnitZ(), 1), -1) << "cut deeper than looked at";
  EXPECT_FALSE(MachinedSurface(Cutter{3, 3, 30}, {}).deviation(Vec3::Zero(), Vec3::UnitZ(), 1));
}

TEST(MachinedSurface, TurningTheWorldTurnsNothing) {
  const Mat3 R = Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const auto wave = [](const Vec3& tip) { return Vec3(0, 0, 0.02 * std::sin(tip.x()) * std::cos(tip.y())); };
  const std::vector<SweepPiece> pieces = passes(10, 5, 0.5, 0.7, wave);
  std::vector<SweepPiece> turned = pieces;
  for (SweepPiece& piece : turned)
    for (ToolPose* pose : {&piece.from, &piece.to}) *pose = {R * pose->tip, R * pose->axis};
  const MachinedSurface here(Cutter{3, 1, 30}, pieces), there(Cutter{3, 1, 30}, turned);
  for (double x = 1; x < 9; x += 1.7) {
    const Vec3 p(x, 2.3, 0), n = Vec3(0.1, 0.05, 1).normalized();
    EXPECT_NEAR(*here.deviation(p, n, 1), *there.deviation(R * p, R * n, 1), 1e-7);
  }
}

}  // namespace
}  // namespace abbe
