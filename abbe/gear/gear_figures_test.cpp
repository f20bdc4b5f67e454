#include "abbe/gear/gear_figures.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "abbe/gear/exact_cut.h"
#include "abbe/gear/test_gears.h"

namespace abbe {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFirstOrder = 1e-6;  // mm: the closed forms are to be met to 0.001 um
constexpr double kNothing = 1e-9;     // mm
constexpr double kShift = 10 * um;

GearInspection inspection_of(const Gear& gear, const WheelInGap& wheel) {
  return *GearInspection::make(gear, wheel, {});
}

double phi_of(const Gear& gear, double roll) {
  return roll + gear.half_gap - involute_of_roll(gear.reference_roll);
}

TEST(Wheel, SpurContactIsThePlaneOfTheWheel) {
  const Gear gear = test::gear_of(test::seed_spec());
  const WheelInGap wheel = test::wheel_of(gear);
  EXPECT_NEAR(wheel.centre_distance, 549 + 150, 1e-9);
  for (const Flank flank : {Flank::right, Flank::left})
    for (const WheelContact& contact : wheel.of(flank)) {
      EXPECT_NEAR(contact.z, 0, 1e-12);
      // The axial profile is the gap itself.
      EXPECT_NEAR(contact.axial, contact.position.y(), 1e-12);
      EXPECT_NEAR(contact.radius, wheel.centre_distance - contact.position.x(), 1e-12);
    }
}

TEST(Wheel, NormalsMeetTheAxis) {
  for (const int hand : {1, -1}) {
    const Gear gear = test::gear_of(test::helical_spec(hand));
    const WheelInGap wheel = test::wheel_of(gear);
    EXPECT_GT(wheel.reach, 0.1);
    for (const Flank flank : {Flank::right, Flank::left})
      for (const WheelContact& contact : wheel.of(flank)) {
        const Vec3 arm = contact.position - Vec3(wheel.centre_distance, 0, 0);
        EXPECT_NEAR(wheel.axis.dot(arm.cross(contact.normal)), 0, 1e-9);
      }
  }
}

TEST(Wheel, TurningAboutItsAxisDoesNothing) {
  const Gear gear = test::gear_of(test::helical_spec());
  const WheelInGap wheel = test::wheel_of(gear);
  Twist turn;
  turn.e = 1e-3 * wheel.axis;
  const WheelDeviations deviations = test::everywhere(gear, wheel, turn);
  for (const double f : flank_field(gear, wheel, deviations, even_heights(gear, 5)))
    EXPECT_NEAR(f, 0, kNothing);
}

TEST(Wheel, AlongTheHelixNothingChanges) {
  // A wheel that is ahead on its helix: up by dz and turned about the gear axis by kappa dz.
  const Gear gear = test::gear_of(test::helical_spec());
  const WheelInGap wheel = test::wheel_of(gear);
  Twist ahead;
  ahead.d = Vec3(0, gear.turn_per_mm * wheel.centre_distance, 1) * 0.01;
  ahead.e = Vec3(0, 0, gear.turn_per_mm) * 0.01;
  const WheelDeviations deviations = test::everywhere(gear, wheel, ahead);
  for (const double f : flank_field(gear, wheel, deviations, even_heights(gear, 5))) EXPECT_NEAR(f, 0, 1e-12);
}

TEST(Wheel, EveryImpossibleWheelIsNamed) {
  const Gear gear = test::gear_of(test::seed_spec());
  const auto trouble_of = [&](const Gear& of, const WheelSpec& spec) {
    const auto made = fit_wheel(of, spec, {});
    EXPECT_TRUE(std::holds_alternative<WheelProblem>(made));
    return std::holds_alternative<WheelProblem>(made) ? std::get<WheelProblem>(made).trouble
                                                      : WheelTrouble::value;
  };
  WheelSpec spec;
  spec.diameter = 40;
  EXPECT_EQ(trouble_of(gear, spec), WheelTrouble::value);
  spec.diameter = 300;
  spec.tip_width = 14;
  EXPECT_EQ(trouble_of(gear, spec), WheelTrouble::larger);
  spec.tip_width = 8;
  EXPECT_TRUE(std::holds_alternative<WheelInGap>(fit_wheel(gear, spec, {})));
  spec.width = 15;
  EXPECT_EQ(trouble_of(gear, spec), WheelTrouble::larger);
  // A wheel that stands across a steep helix.
  const Gear helical = test::gear_of(test::helical_spec());
  spec = {};
  spec.diameter = 300;
  spec.swivel = -30 * deg;
  EXPECT_EQ(trouble_of(helical, spec), WheelTrouble::mesh);
}

TEST(FlankDeviation, PerfectMachineMakesAPerfectGear) {
  GearSpec relieved = test::helical_spec();
  relieved.tip_relief = 0.02;
  relieved.tip_relief_length = 4;
  for (const GearSpec& spec : {test::seed_spec(), test::helical_spec(), test::helical_spec(-1), relieved}) {
    const Gear gear = test::gear_of(spec);
    const WheelInGap wheel = test::wheel_of(gear);
    const WheelDeviations nothing = test::none(gear, wheel);
    for (const double f : flank_field(gear, wheel, nothing, even_heights(gear, 7)))
      EXPECT_NEAR(f, 0, kNothing);
    // And as the body of the wheel cuts it.
    for (const Flank flank : {Flank::right, Flank::left})
      for (const double part : {0.1, 0.5, 0.95})
        for (const double z : {-20.0, 0.0, 15.0}) {
          const double roll = gear.form_roll + part * (gear.tip_roll - gear.form_roll);
          const auto f = cut_exactly(gear, wheel, nothing, 3, flank, roll, z);
          ASSERT_TRUE(f) << part << ' ' << z;
          EXPECT_NEAR(*f, 0, kNothing) << part << ' ' << z;
        }
  }
}

TEST(FlankDeviation, FirstOrderEqualsTheBodyOfTheWheel) {
  // What is left is of second order: a tenth of the deviations leaves a hundredth.
  const Gear gear = test::gear_of(test::helical_spec());
  const WheelInGap wheel = test::wheel_of(gear);
  const double kSecondOrder[] = {2e-5, 2e-7};
  int k = 0;
  for (const double size : {1.0, 0.1}) {
    Twist twist;
    twist.d = Vec3(8, -11, 6) * um * size;
    twist.e = Vec3(20, -30, 15) * urad * size;
    WheelDeviations deviations = test::everywhere(gear, wheel, twist);
    for (std::size_t node = 0; node < deviations.nodes; ++node)
      deviations.of(0, node).d += Vec3(0.1, -0.2, 0.1) * um * size * deviations.height(node);
    for (const Flank flank : {Flank::right, Flank::left})
      for (const double part : {0.05, 0.6}) {
        const double roll = gear.form_roll + part * (gear.tip_roll - gear.form_roll);
        const auto exact = cut_exactly(gear, wheel, deviations, 0, flank, roll, 12);
        const auto contact = wheel_contact(gear, wheel, flank, roll);
        ASSERT_TRUE(exact && contact);
        EXPECT_NEAR(flank_deviation(gear, wheel, deviations, 0, *contact, 12), *exact, kSecondOrder[k]);
      }
    ++k;
  }
}

TEST(FlankDeviation, SingleErrorsHaveTheirClosedForms) {
  const Gear gear = test::gear_of(test::seed_spec());
  const WheelInGap wheel = test::wheel_of(gear, 3);
  const auto at = [&](const Twist& twist, Flank flank, double roll) {
    return flank_deviation(gear, wheel, test::everywhere(gear, wheel, twist), 0,
                           *wheel_contact(gear, wheel, flank, roll), 0);
  };
  const std::array rolls = {gear.form_roll, gear.reference_roll, gear.tip_roll};
  // Worked numbers of the displaced involute, um; form, reference, tip.
  const std::array radial = {2.9511, 3.5767, 4.1456}, tangential = {-9.5546, -9.3385, -9.1002};
  for (std::size_t i = 0; i < rolls.size(); ++i) {
    const double phi = phi_of(gear, rolls[i]);
    EXPECT_NEAR(at(test::unit_twist(0, kShift), Flank::right, rolls[i]) / um, radial[i], 5e-5);
    EXPECT_NEAR(at(test::unit_twist(0, kShift), Flank::left, rolls[i]) / um, radial[i], 5e-5);
    EXPECT_NEAR(at(test::unit_twist(1, kShift), Flank::right, rolls[i]) / um, tangential[i], 5e-5);
    EXPECT_NEAR(at(test::unit_twist(1, kShift), Flank::left, rolls[i]) / um, -tangential[i], 5e-5);
    // f = dx sin phi -+ dy cos phi
    EXPECT_NEAR(at(test::unit_twist(0, kShift), Flank::right, rolls[i]), kShift * std::sin(phi), kNothing);
    // Along the gap and swivelled about x: nothing in first order.
    EXPECT_NEAR(at(test::unit_twist(2, kShift), Flank::right, rolls[i]), 0, kNothing);
    EXPECT_NEAR(at(test::unit_twist(3, 1e-4), Flank::right, rolls[i]), 0, kNothing);
  }
  // An index error of one second of arc: the wheel turned about the gear axis. -+ r_b dgamma
  Twist index;
  index.e = Vec3(0, 0, arcsec);
  index.d = index.e.cross(Vec3(wheel.centre_distance, 0, 0));
  for (const double roll : rolls) {
    EXPECT_NEAR(at(index, Flank::right, roll) / um, -2.56945, 5e-6);
    EXPECT_NEAR(at(index, Flank::left, roll) / um, 2.56945, 5e-6);
  }
}

TEST(FlankDeviation, DeviationsAreSuperposed) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  const Gear gear = test::gear_of(test::helical_spec());
  const WheelInGap wheel = test::wheel_of(gear);
  const auto draw = [&] {
    WheelDeviations out = test::none(gear, wheel);
    for (Twist& value : out.values)
      for (int i = 0; i < 3; ++i) value.d[i] = normal(random), value.e[i] = 1e-3 * normal(random);
    return out;
  };
  const WheelDeviations a = draw(), b = draw();
  WheelDeviations sum = a;
  for (std::size_t i = 0; i < sum.values.size(); ++i)
    sum.values[i] = {a.values[i].d + 2 * b.values[i].d, a.values[i].e + 2 * b.values[i].e};
  const std::vector<double> z = even_heights(gear, 3);
  const auto fa = flank_field(gear, wheel, a, z), fb = flank_field(gear, wheel, b, z),
             fs = flank_field(gear, wheel, sum, z);
  for (std::size_t i = 0; i < fs.size(); i += 17) EXPECT_NEAR(fs[i], fa[i] + 2 * fb[i], 1e-12);
  // The field is made of single points: gap 2, left flank, roll 5, height 1.
  const std::size_t rolls = wheel.contacts[0].size();
  EXPECT_NEAR(fa[((2 * 2 + 1) * rolls + 5) * 3 + 1],
              flank_deviation(gear, wheel, a, 2, wheel.of(Flank::left)[5], z[1]), 1e-12);
}

TEST(FlankDeviation, ARightHandGearIsTheMirrorImageOfALeftHandOne) {
  const Gear right = test::gear_of(test::helical_spec(1)), left = test::gear_of(test::helical_spec(-1));
  const WheelInGap a = test::wheel_of(right), b = test::wheel_of(left);
  Twist twist, mirrored;
  twist.d = Vec3(3, 5, -7) * um;
  twist.e = Vec3(20, -30, 40) * urad;
  // z -> -z: displacements along z and rotations about x and y change their signs.
  mirrored.d = Vec3(3, 5, 7) * um;
  mirrored.e = Vec3(-20, 30, 40) * urad;
  for (std::size_t i = 0; i < a.contacts[0].size(); ++i)
    for (const Flank flank : {Flank::right, Flank::left})
      EXPECT_NEAR(flank_deviation(right, a, test::everywhere(right, a, twist), 0, a.of(flank)[i], 13),
                  flank_deviation(left, b, test::everywhere(left, b, mirrored), 0, b.of(flank)[i], -13),
                  1e-12);
}

TEST(FlankDeviation, CrowningBendsTheFaceAndItsRestIsReported) {
  GearSpec spec = test::seed_spec();
  spec.helix_crowning = 20 * um;
  const Gear gear = test::gear_of(spec);
  const WheelInGap wheel = test::wheel_of(gear);
  const WheelDeviations nothing = test::none(gear, wheel);
  const auto contact = [&](double roll) { return *wheel_contact(gear, wheel, Flank::right, roll); };
  // Exact at the reference cylinder; elsewhere C (sin phi / sin phi_ref - 1) at the ends of the face.
  EXPECT_NEAR(flank_deviation(gear, wheel, nothing, 0, contact(gear.reference_roll), 50), 0, kNothing);
  const double wanted =
      -20 * um * (std::sin(phi_of(gear, gear.tip_roll)) / std::sin(phi_of(gear, gear.reference_roll)) - 1);
  EXPECT_NEAR(flank_deviation(gear, wheel, nothing, 0, contact(gear.tip_roll), 50), wanted, kNothing);
  EXPECT_LT(wanted, -3 * um);
  const auto exact = cut_exactly(gear, wheel, nothing, 0, Flank::right, gear.tip_roll, 40);
  ASSERT_TRUE(exact);
  // The path goes down towards the ends, so that the wheel touches a little further out: 1 % of the crowning.
  EXPECT_NEAR(*exact, flank_deviation(gear, wheel, nothing, 0, contact(gear.tip_roll), 40), 0.01 * 20 * um);
}

TEST(TraceFigures, FiguresOfAStraightLine) {
  const std::vector<double> x = {0, 1, 2, 3, 4}, f = {1, 3, 5, 7, 9};
  const TraceFigures figures = trace_figures(x, f, 4);
  EXPECT_NEAR(figures.total, 8, 1e-14);
  EXPECT_NEAR(figures.form, 0, 1e-14);
  EXPECT_NEAR(figures.slope, 8, 1e-14);
  EXPECT_EQ(trace_figures({}, {}, 4).total, 0);
  const std::vector<double> one = {2, 2};
  EXPECT_EQ(trace_figures(one, one, 4).slope, 0);
}

/// Height of the mean line of sin(phi) over [phi_1, phi_2], by the integrals of the least-squares line.
double mean_line_of_sine(double phi_1, double phi_2) {
  // slope L = 12 / L^2 integral (p - middle) sin p dp
  const double length = phi_2 - phi_1, middle = 0.5 * (phi_1 + phi_2);
  const auto antiderivative = [&](double p) { return std::sin(p) - (p - middle) * std::cos(p); };
  return 12 / (length * length) * (antiderivative(phi_2) - antiderivative(phi_1));
}

TEST(GearInspection, ProfileSlopeOfARadialShift) {
  const Gear gear = test::gear_of(test::seed_spec());
  const WheelInGap wheel = test::wheel_of(gear);
  const GearFigures figures =
      inspection_of(gear, wheel).figures(test::everywhere(gear, wheel, test::unit_twist(0, kShift)));
  const double end = gear.form_roll + 0.95 * (gear.tip_roll - gear.form_roll);
  const double wanted = kShift * mean_line_of_sine(phi_of(gear, gear.form_roll), phi_of(gear, end));
  EXPECT_NEAR(wanted / um, 1.13, 0.02);
  for (const auto& tooth : figures.teeth)
    for (const FlankFigures& flank : tooth) {
      EXPECT_NEAR(flank.profile.slope, wanted, 0.1 * kFirstOrder);
      EXPECT_NEAR(flank.profile.total,
                  kShift * (std::sin(phi_of(gear, end)) - std::sin(phi_of(gear, gear.form_roll))), kNothing);
      EXPECT_NEAR(flank.helix.total, 0, kNothing);
    }
  EXPECT_NEAR(figures.F_r, 0, kNothing);
  EXPECT_NEAR(figures.ball[0], kShift, kNothing);
  EXPECT_NEAR(figures.pitch[0].F_p, 0, kNothing);
}

TEST(GearInspection, EccentricityGivesItsPitchCurve) {
  const Gear gear = test::gear_of(test::seed_spec());
  const WheelInGap wheel = test::wheel_of(gear);
  // The gear stands off by -e towards the right flank of gap 0: the wheel is off by e.
  WheelDeviations deviations = test::none(gear, wheel);
  for (std::size_t gap = 0; gap < 94; ++gap) {
    const double angle = 2 * kPi * static_cast<double>(gap) / 94 - gear.half_gap;
    for (std::size_t node = 0; node < deviations.nodes; ++node)
      deviations.of(gap, node).d = kShift * Vec3(std::cos(angle), -std::sin(angle), 0);
  }
  const GearFigures figures = inspection_of(gear, wheel).figures(deviations);
  // The worked numbers: 2 e / cos alpha and that times sin(pi / z), sampled at 94 teeth.
  EXPECT_NEAR(figures.pitch[0].F_p / um, 21.2799, 1e-4);
  EXPECT_NEAR(figures.pitch[0].f_p / um, 0.71107, 1e-5);
  const double largest = 2 * kShift / std::cos(gear.transverse_angle);
  EXPECT_NEAR(figures.pitch[1].F_p, largest, largest * (1 - std::cos(kPi / 94)));
  EXPECT_NEAR(figures.F_r, 2 * kShift, 2 * kShift * (1 - std::cos(kPi / 94)));
  // The whole curve of the right flanks: -e sin(theta + alpha) / cos alpha.
  for (std::size_t i = 0; i < 94; ++i) {
    const auto position = [&](double tooth) {
      return -kShift * std::sin(2 * kPi * tooth / 94 + gear.transverse_angle) /
             std::cos(gear.transverse_angle);
    };
    EXPECT_NEAR(figures.pitch[0].index[i], position(static_cast<double>(i)) - position(0), kNothing) << i;
  }
}

TEST(GearInspection, IndexErrorIsPitchOnly) {
  const Gear gear = test::gear_of(test::helical_spec());
  const WheelInGap wheel = test::wheel_of(gear);
  WheelDeviations deviations = test::none(gear, wheel);
  const double turn = 5 * arcsec;
  for (std::size_t node = 0; node < deviations.nodes; ++node) {
    Twist& twist = deviations.of(7, node);
    twist.e = Vec3(0, 0, turn);
    twist.d = twist.e.cross(Vec3(wheel.centre_distance, 0, 0));
  }
  const GearFigures figures = inspection_of(gear, wheel).figures(deviations);
  // Gap 7 makes the right flank of tooth 7 and the left flank of tooth 6; both are ahead by r dgamma.
  const double arc = gear.reference_radius * turn;
  EXPECT_NEAR(figures.pitch[0].index[7], arc, kNothing);
  EXPECT_NEAR(figures.pitch[1].index[6], arc, kNothing);
  EXPECT_NEAR(figures.pitch[0].index[6], 0, kNothing);
  EXPECT_NEAR(figures.pitch[0].f_p, arc, kNothing);
  EXPECT_NEAR(figures.pitch[0].F_p, arc, kNothing);
  EXPECT_NEAR(figures.F_r, 0, kNothing);
  EXPECT_NEAR(figures.teeth[7][0].profile.total, 0, kNothing);
  EXPECT_NEAR(figures.teeth[7][0].helix.total, 0, kNothing);
}

TEST(GearInspection, TiltOfTheFeedIsHelixSlope) {
  const Gear gear = test::gear_of(test::seed_spec());
  const WheelInGap wheel = test::wheel_of(gear);
  const GearInspection inspection = inspection_of(gear, wheel);
  EXPECT_NEAR(inspection.helix_length(), 100 - 2 * 5, 1e-12);  // 5 % is less than one module
  const double phi = phi_of(gear, gear.reference_roll), tilt = 20 * urad;
  WheelDeviations sideways = test::none(gear, wheel), taper = sideways;
  for (std::size_t gap = 0; gap < 94; ++gap)
    for (std::size_t node = 0; node < sideways.nodes; ++node) {
      sideways.of(gap, node).d.y() = -tilt * sideways.height(node);
      taper.of(gap, node).d.x() = tilt * taper.height(node);
    }
  const GearFigures a = inspection.figures(sideways), b = inspection.figures(taper);
  EXPECT_NEAR(a.teeth[0][0].helix.slope, tilt * 90 * std::cos(phi), kNothing);
  EXPECT_NEAR(a.teeth[0][1].helix.slope, -tilt * 90 * std::cos(phi), kNothing);
  EXPECT_NEAR(b.teeth[5][0].helix.slope, tilt * 90 * std::sin(phi), kNothing);
  EXPECT_NEAR(b.teeth[5][1].helix.slope, tilt * 90 * std::sin(phi), kNothing);
  EXPECT_NEAR(b.teeth[5][1].helix.form, 0, kNothing);
}

TEST(GearInspection, RunoutOfAPerfectGearIsZero) {
  const Gear gear = test::gear_of(test::helical_spec());
  const WheelInGap wheel = test::wheel_of(gear);
  const GearInspection inspection = inspection_of(gear, wheel);
  const GearFigures figures = inspection.figures(test::none(gear, wheel));
  EXPECT_EQ(figures.F_r, 0);
  EXPECT_EQ(figures.pitch[1].F_p, 0);
  EXPECT_EQ(figures.teeth.size(), 41U);
  const FlankTraces traces = inspection.traces(test::none(gear, wheel), 40, Flank::left);
  EXPECT_EQ(traces.profile.size(), traces.roll_length.size());
  EXPECT_NEAR(traces.roll_length.back(), gear.base_radius * gear.tip_roll, 1e-9);
}

}  // namespace
}  // namespace abbe
