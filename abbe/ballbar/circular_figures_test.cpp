#include "abbe/ballbar/circular_figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "abbe/core/units.h"

namespace abbe {
namespace {

constexpr double kPrinted = 6e-10;   // um: the worked numbers have nine decimals
constexpr double kRounding = 1e-12;  // mm

/// 36 points every 10 deg in um: 2 + 3 cos 2t - 1.5 sin 2t + 1.2 sin 3t + 0.7 cos 5t counter-clockwise, the
/// signs of the second and the last turned clockwise.
BallbarTest worked_example() {
  BallbarTest test;
  test.radius = 100;
  test.feed = 10;
  for (const int direction : {+1, -1}) {
    BallbarRun run;
    run.direction = direction;
    for (int i = 0; i < 36; ++i) {
      const double t = direction * 10 * i * deg;
      run.angle.push_back(t);
      run.deviation.push_back((2 + 3 * std::cos(2 * t) - direction * 1.5 * std::sin(2 * t) +
                               1.2 * std::sin(3 * t) + direction * 0.7 * std::cos(5 * t)) *
                              um);
    }
    test.runs.push_back(run);
  }
  return test;
}

TEST(CircularFigures, WorkedExample) {
  const TestFigures figures = circular_figures(worked_example());
  ASSERT_EQ(figures.directions.size(), 2U);
  for (const CircularFigures& f : figures.directions) {
    EXPECT_NEAR(f.least_squares.x, 0, kRounding);
    EXPECT_NEAR(f.least_squares.y, 0, kRounding);
    EXPECT_NEAR(f.least_squares.mean / um, 2, kPrinted);
    EXPECT_NEAR(f.least_squares.width() / um, 8.805255888, kPrinted);
    EXPECT_NEAR(f.f_max / um, 6.605255888, kPrinted);
    EXPECT_NEAR(f.f_min / um, -2.2, kPrinted);
    EXPECT_NEAR(f.minimum_zone.width() / um, 8.139203618, kPrinted);
  }
  EXPECT_NEAR(figures.least_squares_both.width() / um, 8.805255888, kPrinted);
  EXPECT_NEAR(figures.minimum_zone_both.width() / um, 8.586582110, kPrinted);
  EXPECT_NEAR(figures.mean_radial_deviation / um, 2.0, kPrinted);
}

TEST(CircularFigures, BothDirectionsAreAtLeastAsWideAsEach) {
  const TestFigures figures = circular_figures(worked_example());
  for (const CircularFigures& f : figures.directions)
    EXPECT_GE(figures.minimum_zone_both.width(), f.minimum_zone.width() - kRounding);
}

TEST(CircularFigures, CentreOffsetIsTheCentre) {
  BallbarTest test = worked_example();
  for (BallbarRun& run : test.runs)
    for (std::size_t i = 0; i < run.angle.size(); ++i)
      run.deviation[i] += 7 * um * std::cos(run.angle[i]) - 4 * um * std::sin(run.angle[i]);
  const TestFigures figures = circular_figures(test);
  EXPECT_NEAR(figures.directions[0].least_squares.x / um, 7, kPrinted);
  EXPECT_NEAR(figures.directions[0].least_squares.y / um, -4, kPrinted);
  EXPECT_NEAR(figures.directions[1].minimum_zone.width() / um, 8.139203618, kPrinted);
  EXPECT_GT(figures.directions[0].f_max_set_up, figures.directions[0].f_max + 2 * um);
}

TEST(MinimumZone, MinimumZoneIsNoWiderThanAnyOther) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 1e-3);
  for (const std::size_t n : {4U, 5U, 12U, 360U, 5000U}) {
    std::vector<double> angle, deviation;
    for (std::size_t i = 0; i < n; ++i) {
      angle.push_back(6.283185307179586 * static_cast<double>(i) / static_cast<double>(n));
      deviation.push_back(noise(random));
    }
    const FittedCircle zone = minimum_zone_circle(angle, deviation);
    ASSERT_TRUE(zone.found) << n;
    EXPECT_LE(zone.width(), least_squares_circle(angle, deviation).width() + kRounding);
    const auto width_about = [&](double x, double y) {
      double low = 1e9, high = -1e9;
      for (std::size_t i = 0; i < n; ++i) {
        const double r = deviation[i] - x * std::cos(angle[i]) - y * std::sin(angle[i]);
        low = std::min(low, r), high = std::max(high, r);
      }
      return high - low;
    };
    for (int k = 0; k < 50; ++k)
      EXPECT_LE(zone.width(),
                width_about(zone.x + 0.3 * noise(random), zone.y + 0.3 * noise(random)) + kRounding);
    for (const double step : {-1e-6, 1e-6}) {
      EXPECT_LE(zone.width(), width_about(zone.x + step, zone.y) + kRounding);
      EXPECT_LE(zone.width(), width_about(zone.x, zone.y + step) + kRounding);
    }
  }
}

TEST(MinimumZone, EqualAnglesAndPerfectCircles) {
  const std::vector<double> angle = {0, 0, 2, 2, 4, 4};
  const std::vector<double> deviation = {1e-3, -1e-3, 1e-3, -1e-3, 1e-3, -1e-3};
  const FittedCircle zone = minimum_zone_circle(angle, deviation);
  ASSERT_TRUE(zone.found);
  EXPECT_NEAR(zone.width(), 2e-3, kRounding);
  const std::vector<double> none(6, 0.0);
  EXPECT_TRUE(minimum_zone_circle(angle, none).found);
  EXPECT_EQ(minimum_zone_circle(angle, none).width(), 0);
}

TEST(MinimumZone, TooFewAnglesAreNotFound) {
  const std::vector<double> angle = {0, 0, 2, 2}, deviation = {1, 2, 3, 4};
  EXPECT_FALSE(minimum_zone_circle(angle, deviation).found);
  EXPECT_FALSE(least_squares_circle(angle, deviation).found);
  EXPECT_FALSE(least_squares_circle(std::vector{1.0, 2.0, std::nan("")}, std::vector{1.0, 2.0, 3.0}).found);
}

}  // namespace
}  // namespace abbe
