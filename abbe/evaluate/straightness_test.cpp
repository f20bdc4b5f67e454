#include "abbe/evaluate/straightness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "abbe/evaluate/monte_carlo.h"

namespace abbe {
namespace {

const std::array<double, 7> kPositions = {0, 100, 200, 300, 400, 500, 600};
const std::array<double, 7> kDeviations = {0, 3, 5, 2, 4, -1, 0};

TEST(Straightness, PublishedExample) {
  const auto figures = straightness_figures(kPositions, kDeviations);
  ASSERT_TRUE(figures);
  EXPECT_NEAR(figures->end_points.value, 6.0, 1e-12);
  EXPECT_NEAR(figures->least_squares.value, 5.642857, 5e-7);
  EXPECT_NEAR(figures->least_squares.line.slope, -0.003214286, 5e-10);
  EXPECT_NEAR(figures->least_squares.line.offset, 2.821428571, 5e-10);
  EXPECT_NEAR(figures->minimum_zone.value, 5.4, 1e-12);
}

TEST(Straightness, MinimumZoneIsTheLeast) {
  RandomStream random(7);
  for (int round = 0; round < 50; ++round) {
    std::vector<double> x, y;
    for (int i = 0; i < 12; ++i) {
      x.push_back(i + 0.5 * random.uniform());
      y.push_back(random.normal());
    }
    const auto figures = straightness_figures(x, y);
    ASSERT_TRUE(figures);
    double least = 1e9;
    for (double slope = -3; slope <= 3; slope += 0.001) {
      double lo = 1e9, hi = -1e9;
      for (std::size_t i = 0; i < x.size(); ++i) {
        lo = std::min(lo, y[i] - slope * x[i]);
        hi = std::max(hi, y[i] - slope * x[i]);
      }
      least = std::min(least, hi - lo);
    }
    EXPECT_LE(figures->minimum_zone.value, least + 1e-12) << round;
    EXPECT_GE(figures->minimum_zone.value, least - 0.02) << round;  // the comb of slopes
  }
}

TEST(Straightness, TrendsDoNotCount) {
  std::array<double, 7> tilted = kDeviations;
  for (std::size_t i = 0; i < tilted.size(); ++i) tilted[i] += 7 - 0.02 * kPositions[i];
  const auto figures = straightness_figures(kPositions, tilted);
  ASSERT_TRUE(figures);
  EXPECT_NEAR(figures->minimum_zone.value, 5.4, 1e-11);
  EXPECT_NEAR(figures->least_squares.line.slope, -0.003214286 - 0.02, 5e-10);
}

TEST(Straightness, RefusesWhatIsNoCourse) {
  EXPECT_FALSE(straightness_figures(std::vector<double>{0}, std::vector<double>{0}));
  EXPECT_FALSE(straightness_figures(std::vector<double>{0, 0}, std::vector<double>{0, 1}));
  EXPECT_FALSE(straightness_figures(std::vector<double>{0, 1}, std::vector<double>{0, NAN}));
}

}  // namespace
}  // namespace abbe
