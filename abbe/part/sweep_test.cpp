#include "abbe/part/sweep.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "abbe/part/test_brute_force.h"

namespace abbe {
namespace {

constexpr double kPico = 1e-9;  // mm
// Poses a piece of 1 mm apart by 1 mm / kPoses: the sampled sweep lacks some of a sharp edge, more on a
// slanted ray.
constexpr int kPoses = 400, kSteps = 300;
constexpr double kSharp = 6.0 / kPoses, kRound = 1e-4;

struct Cases {
  std::mt19937 random{42};
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
  }
  Vec3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Vec3 lean(double size) { return (Vec3::UnitZ() + vector(size)).normalized(); }
  SweepPiece piece(double turn) {
    SweepPiece out;
    out.from = {vector(0.5), lean(0.3)};
    out.to = {vector(0.5), (out.from.axis + vector(turn)).normalized()};
    out.worn = uniform(0, 0.02);
    return out;
  }
  /// A ray that looks at the lower side of a cutter near the origin.
  Ray ray(double wide) { return {vector(wide) + Vec3(0, 0, uniform(-1, 4)), lean(0.9), -2, 2}; }
};

Cutter cutter_of(int kind) {
  return kind == 0 ? Cutter{3, 3, 20} : kind == 1 ? Cutter{4, 0, 20} : Cutter{4, 1, 20};
}

TEST(CutterDistance, DistanceIsThatOfTheNearestPoint) {
  // f = 0 on the outline; outside, f away from it along the slope.
  for (int kind = 0; kind < 3; ++kind) {
    const Cutter cutter = cutter_of(kind);
    for (double h = -3; h < 24; h += 0.37) {
      for (double rho = 0.01; rho < 8; rho += 0.31) {
        const CutterDistance f = cutter_distance(cutter, 0, h, rho);
        EXPECT_NEAR(std::hypot(f.along, f.across), 1, 1e-12);
        const ToolPose pose;
        if (h <= cutter.length) {
          EXPECT_EQ(f.value <= 0, inside_cutter(cutter, pose, 0, Vec3(rho, 0, h)))
              << kind << ' ' << h << ' ' << rho;
        }
        if (f.value <= 0) continue;
        EXPECT_NEAR(cutter_distance(cutter, 0, h - f.value * f.along, rho - f.value * f.across).value, 0,
                    1e-12);
        if (cutter.corner == 0) continue;
        EXPECT_NEAR(cutter_distance(cutter, 0.05, h, rho).value, f.value + 0.05, 1e-14) << "worn";
      }
    }
  }
}

TEST(CutterDistance, SmoothOutside) {
  // The formula changes at the height of the roundings, at the top, and at the radius of the core.
  constexpr double kStep = 1e-9, kNoJump = 1e-6;  // mm; slopes turn by less than 1 per 0.01 mm
  for (int kind = 0; kind < 3; ++kind) {
    const Cutter cutter = cutter_of(kind);
    const double core = cutter.radius - cutter.corner;
    for (const double worn : {0.0, 0.02}) {
      const double bare = std::max(0.0, worn - cutter.corner);  // taken off the cylinder within
      for (const double off : {0.01, 0.7, 3.0}) {
        const auto is_smooth = [&](double h, double rho, double along, double across) {
          const CutterDistance a = cutter_distance(cutter, worn, h - along * kStep, rho - across * kStep);
          const CutterDistance b = cutter_distance(cutter, worn, h + along * kStep, rho + across * kStep);
          EXPECT_GT(a.value, 0);
          EXPECT_NEAR(a.along, b.along, kNoJump) << kind << ' ' << worn << ' ' << h << ' ' << rho;
          EXPECT_NEAR(a.across, b.across, kNoJump) << kind << ' ' << worn << ' ' << h << ' ' << rho;
        };
        is_smooth(cutter.corner + bare, cutter.radius + off, 1, 0);
        is_smooth(cutter.length - bare, cutter.radius + off, 1, 0);
        if (core > bare) {
          is_smooth(-off, core - bare, 0, 1);
          is_smooth(cutter.length + cutter.corner + off, core - bare, 0, 1);
        }
      }
    }
  }
}

TEST(Sweep, EqualsDenseSampling) {
  Cases cases;
  int hits = 0;
  for (int round = 0; round < 240; ++round) {
    const Cutter cutter = cutter_of(round % 3);
    const SweepPiece piece = cases.piece(round % 2 == 0 ? 0 : 0.004);
    const Ray ray = cases.ray(4);
    const std::optional<double> is = entry_of(cutter, piece, ray);
    const std::optional<double> should = brute_force_entry(cutter, piece, ray, kPoses, kSteps);
    // Of a ray that only grazes, either may see nothing.
    if (is.has_value() != should.has_value()) {
      Ray wider = ray;
      wider.high += 0.05;
      const Cutter thicker{cutter.radius + 0.01, cutter.corner + (cutter.corner > 0 ? 0.01 : 0),
                           cutter.length};
      EXPECT_TRUE(is && entry_of(thicker, piece, wider)) << "round " << round;
      continue;
    }
    if (!is) continue;
    ++hits;
    const double rounding = cutter.corner == 0 ? kSharp : kRound;
    EXPECT_LE(*is, *should + kPico) << "round " << round;
    EXPECT_GE(*is, *should - rounding * (1 + 20 * piece.worn)) << "round " << round;
  }
  EXPECT_GT(hits, 60);
}

TEST(Sweep, BallEqualsTheGeneralWay) {
  Cases cases;
  int hits = 0;
  for (int round = 0; round < 3000; ++round) {
    const Cutter ball{3, 3, 20};
    const SweepPiece piece = cases.piece(0);
    const Ray ray = cases.ray(4);
    const auto fast = entry_of(ball, piece, ray), general = entry_of_any(ball, piece, ray);
    ASSERT_EQ(fast.has_value(), general.has_value()) << round;
    if (!fast) continue;
    ++hits;
    EXPECT_NEAR(*fast, *general, 1e-6 * (1 + std::abs(*fast))) << round;
  }
  EXPECT_GT(hits, 1000);
}

TEST(Sweep, MovingBothMovesNothing) {
  Cases cases;
  for (int round = 0; round < 200; ++round) {
    const Cutter cutter = cutter_of(round % 3);
    const SweepPiece piece = cases.piece(0.003);
    const Ray ray = cases.ray(4);
    const Mat3 R = Eigen::AngleAxisd(cases.uniform(-3, 3), cases.lean(2)).toRotationMatrix();
    const Vec3 d = cases.vector(50);
    SweepPiece moved = piece;
    for (ToolPose* pose : {&moved.from, &moved.to}) *pose = {R * pose->tip + d, R * pose->axis};
    const auto here = entry_of(cutter, piece, ray);
    const auto there = entry_of(cutter, moved, {R * ray.p + d, R * ray.n, ray.low, ray.high});
    ASSERT_EQ(here.has_value(), there.has_value()) << round;
    if (!here) continue;
    EXPECT_NEAR(*here, *there, 1e-6) << round;
  }
}

TEST(Sweep, ASwingingShankReachesFarthestAtItsEnd) {
  // The tip stands, the axis swings by a to both sides: at the height 15 the shank reaches x = -(R + 15 sin
  // a) / cos a.
  for (const double a : {2e-3, -2e-3}) {
    const SweepPiece swing{{Vec3::Zero(), Vec3(-std::sin(a), 0, std::cos(a))},
                           {Vec3::Zero(), Vec3(std::sin(a), 0, std::cos(a))},
                           0};
    const double x = (4 + 15 * std::sin(std::abs(a))) / std::cos(a);
    for (const double side : {1.0, -1.0}) {
      const Ray ray{Vec3(-6 * side, 0, 15), side * Vec3::UnitX(), 0, 4};
      EXPECT_NEAR(entry_of({4, 1, 30}, swing, ray).value_or(99), 6 - x, kPico) << a << ' ' << side;
    }
  }
}

TEST(Sweep, KnownEntries) {
  const SweepPiece along_x{{Vec3(0, 0, 1), Vec3::UnitZ()}, {Vec3(10, 0, 1), Vec3::UnitZ()}, 0};
  const Ray up{Vec3(5, 1, 0), Vec3::UnitZ(), -2, 3};
  EXPECT_NEAR(*entry_of({3, 3, 20}, along_x, up), 1 + 3 - std::sqrt(8.0), kPico);
  EXPECT_NEAR(*entry_of({4, 0, 20}, along_x, up), 1, kPico);
  EXPECT_NEAR(*entry_of({4, 1, 20}, along_x, up), 1, kPico);
  EXPECT_NEAR(*entry_of({4, 1, 20}, along_x, {Vec3(5, 3.5, 0), Vec3::UnitZ(), -2, 3}), 2 - std::sqrt(0.75),
              kPico);
  // A wall at the side of the cutter, cut by the shank of a ball, looked at from inside the material.
  EXPECT_NEAR(*entry_of({3, 3, 20}, along_x, {Vec3(5, -3.5, 9), Vec3::UnitY(), -2, 3}), 0.5, kPico);
  SweepPiece worn = along_x;
  worn.worn = 0.1;
  EXPECT_NEAR(*entry_of({3, 3, 20}, worn, up), 1 + 3 - std::sqrt(2.9 * 2.9 - 1), kPico);
  EXPECT_FALSE(entry_of({3, 3, 20}, along_x, {Vec3(5, 3.1, 0), Vec3::UnitZ(), -2, 3}));
  EXPECT_EQ(*entry_of({3, 3, 20}, along_x, {Vec3(5, 0, 3), Vec3::UnitZ(), -1, 1}), -1)
      << "deeper than looked at";
}

}  // namespace
}  // namespace abbe
