#include "abbe/gear/gear.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "abbe/gear/flank.h"
#include "abbe/gear/test_gears.h"

namespace abbe {
namespace {

constexpr double kPrinted = 1e-9;     // digits of the published numbers
constexpr double kDifference = 1e-6;  // central differences

GearTrouble trouble_of(const GearSpec& spec) {
  const auto made = make_gear(spec);
  EXPECT_TRUE(std::holds_alternative<GearProblem>(made));
  return std::holds_alternative<GearProblem>(made) ? std::get<GearProblem>(made).trouble : GearTrouble::value;
}

TEST(Gear, SeedGearHasItsPublishedNumbers) {
  // Computed by hand from ISO 21771 for module 12 mm, 94 teeth, 20 deg.
  const Gear gear = test::gear_of(test::seed_spec());
  EXPECT_NEAR(2 * gear.reference_radius, 1128, kPrinted);
  EXPECT_NEAR(2 * gear.base_radius, 1059.9732762465, kPrinted);
  EXPECT_NEAR(2 * gear.tip_radius, 1152, kPrinted);
  EXPECT_NEAR(2 * gear.root_radius, 1098, kPrinted);
  EXPECT_NEAR(2 * gear.form_radius, 1105.9674552762, kPrinted);
  EXPECT_NEAR(gear.base_radius * gear.form_roll, 157.8137080337, kPrinted);
  EXPECT_NEAR(gear.base_radius * gear.reference_roll, 192.8993608357, kPrinted);
  EXPECT_NEAR(gear.base_radius * gear.tip_roll, 225.5884824427, kPrinted);
  EXPECT_NEAR(gear.reference_roll / deg, 20.853958292, kPrinted);
  EXPECT_NEAR(involute_of_roll(gear.reference_roll), 0.0149043839, 1e-10);
}

TEST(Gear, EveryImpossibleGearIsNamed) {
  GearSpec spec = test::seed_spec();
  spec.teeth = 12;
  EXPECT_EQ(trouble_of(spec), GearTrouble::undercut);
  spec.profile_shift = 0.5;  // enough: x > 1 - 12 sin^2 20 / 2 = 0.298
  EXPECT_TRUE(std::holds_alternative<Gear>(make_gear(spec)));
  spec = test::seed_spec();
  spec.teeth = 8;
  spec.profile_shift = 0.8;
  EXPECT_EQ(trouble_of(spec), GearTrouble::pointed);
  spec = test::seed_spec();
  spec.form_diameter = 1000;
  EXPECT_EQ(trouble_of(spec), GearTrouble::undercut);
  spec.form_diameter = 1140;
  EXPECT_EQ(trouble_of(spec), GearTrouble::order);
  spec = test::seed_spec();
  spec.profile_shift = 2.5;
  spec.form_diameter = 1062;
  spec.root_diameter = 1060;
  spec.tip_diameter = 1152;
  EXPECT_EQ(trouble_of(spec), GearTrouble::no_gap);
  for (double* number :
       {&spec.module, &spec.pressure_angle, &spec.helix_angle, &spec.profile_shift, &spec.face_width})
    for (const double bad : {-100.0, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
      const double was = *number;
      *number = bad;
      EXPECT_EQ(trouble_of(spec), GearTrouble::value);
      *number = was;
    }
  spec = test::seed_spec();
  spec.tip_relief = 0.03;
  EXPECT_EQ(trouble_of(spec), GearTrouble::value);
}

GearSpec modified_spec() {
  GearSpec spec = test::helical_spec();
  spec.tip_relief = 0.02;
  spec.tip_relief_length = 4;
  spec.profile_crowning = 0.005;
  spec.helix_crowning = 0.012;
  return spec;
}

TEST(Flank, NormalIsAcrossTheSurface) {
  for (const GearSpec& spec :
       {test::seed_spec(), test::helical_spec(), test::helical_spec(-1), modified_spec()}) {
    const Gear gear = test::gear_of(spec);
    for (const Flank flank : {Flank::right, Flank::left})
      for (const double roll : {0.2 * gear.tip_roll + 0.8 * gear.form_roll, 0.97 * gear.tip_roll})
        for (const double z : {-20.0, 3.0}) {
          const double h = 1e-5;
          const auto at = [&](double r, double height) {
            return flank_point(gear, flank, r, height, Modified::all).position;
          };
          const FlankPoint point = flank_point(gear, flank, roll, z, Modified::all);
          const Vec3 by_roll = (at(roll + h, z) - at(roll - h, z)) / (2 * h),
                     by_z = (at(roll, z + h) - at(roll, z - h)) / (2 * h);
          EXPECT_NEAR(point.normal.dot(by_roll.normalized()), 0, kDifference);
          EXPECT_NEAR(point.normal.dot(by_z.normalized()), 0, kDifference);
          EXPECT_NEAR(point.normal.norm(), 1, 1e-14);
          // Out of the material: into the gap, whose middle at this height is turned by the helix.
          const Eigen::AngleAxisd turn(gear.turn_per_mm * z, Vec3::UnitZ());
          const Vec3 into_gap = turn * Vec3(0, -side_of_gap(flank), 0);
          EXPECT_GT(point.normal.dot(into_gap), 0.5);
          EXPECT_GT(point.normal.dot(turn * Vec3::UnitX()), 0);
        }
  }
}

TEST(Flank, NormalOfTheUnmodifiedFlankHasTheBaseHelixAngle) {
  const Gear gear = test::gear_of(test::helical_spec());
  for (const Flank flank : {Flank::right, Flank::left}) {
    const FlankPoint point = flank_point(gear, flank, gear.reference_roll, 7, Modified::none);
    EXPECT_NEAR(point.normal.z(), side_of_gap(flank) * std::sin(gear.base_helix_angle), 1e-14);
    EXPECT_NEAR(point.normal.dot(point.tangent), std::cos(gear.base_helix_angle), 1e-14);
  }
}

TEST(Flank, RadiusFollowsTheRoll) {
  const Gear gear = test::gear_of(test::helical_spec());
  for (const double roll : even_rolls(gear, 5)) {
    const Vec3 p = flank_point(gear, Flank::left, roll, 11, Modified::none).position;
    EXPECT_NEAR(std::hypot(p.x(), p.y()), gear.base_radius * std::hypot(1.0, roll), 1e-11);
    EXPECT_NEAR(roll_at(gear, std::hypot(p.x(), p.y())), roll, 1e-12);
  }
}

TEST(Flank, GapAtTheReferenceCylinderHasItsWidth) {
  const Gear gear = test::gear_of(test::helical_spec());
  const Vec3 p = flank_point(gear, Flank::right, gear.reference_roll, 0, Modified::none).position;
  // Pitch less tooth: p_t - (pi / 2 + 2 x tan alpha_n) m_n / cos beta, half of it.
  const double module = 4 / std::cos(15 * deg);
  const double gap = std::numbers::pi * module - (std::numbers::pi / 2 + 0.4 * std::tan(20 * deg)) * module;
  EXPECT_NEAR(std::atan2(p.y(), p.x()) * gear.reference_radius, gap / 2, 1e-12);
}

TEST(Flank, LeftIsRightTurnedOver) {
  // Half a turn about x: what a gap looks like from the other end.
  const Gear gear = test::gear_of(modified_spec());
  const Eigen::AngleAxisd over(std::numbers::pi, Vec3::UnitX());
  for (const double roll : even_rolls(gear, 4)) {
    const FlankPoint right = flank_point(gear, Flank::right, roll, 9, Modified::all),
                     left = flank_point(gear, Flank::left, roll, -9, Modified::all);
    EXPECT_LT((over * right.position - left.position).norm(), 1e-12);
    EXPECT_LT((over * right.normal - left.normal).norm(), 1e-12);
  }
}

TEST(Flank, AHelixOfTheOtherHandIsAMirrorImage) {
  const Gear right_hand = test::gear_of(test::helical_spec(1)),
             left_hand = test::gear_of(test::helical_spec(-1));
  const Vec3 a = flank_point(right_hand, Flank::right, 0.3, 12, Modified::none).position,
             b = flank_point(left_hand, Flank::right, 0.3, -12, Modified::none).position;
  EXPECT_LT((a - Vec3(b.x(), b.y(), -b.z())).norm(), 1e-12);
  // Right hand: going up along the tooth it turns counter-clockwise.
  const Vec3 low = flank_point(right_hand, Flank::right, 0.3, 0, Modified::none).position;
  EXPECT_GT(low.cross(a).z(), 0);
}

}  // namespace
}  // namespace abbe
