#include "abbe/identify/deviation_uncertainty.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "abbe/identify/test_circles.h"

namespace abbe {
namespace {

using test::Circle;
using test::machine_of;
using test::measured;

const std::string kMill = "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n";

IdentifyOptions only_squareness() {
  IdentifyOptions options;
  options.terms = {0, 0, 0, true, false, false, false, false, false};
  return options;
}

// EC0Y turns the direction of Y: the tip at y is off by -EC0Y y along X, and by nothing else. Over 9 places
// from -R to R the mean of y^2 is R^2 5/12.
TEST(DeviationUncertainty, SquarenessTiltsTheBox) {
  const Machine machine = machine_of(kMill);
  const std::vector<BallbarTest> tests = {
      measured(machine, {{0, 1}, 100, 20, 360, 0, 360, "", true, {20, 0, 0}})};
  const Identification found = identifiability(machine, tests, only_squareness());
  ASSERT_EQ(found.terms.size(), 1U);
  const double u = found.terms[0].uncertainty;
  ASSERT_GT(u, 0);
  const DeviationUncertainty space = uncertainty_of_deviation(machine, found, tests);
  EXPECT_NEAR(space.least[0], -80, 0.01);
  EXPECT_NEAR(space.most[0], 120, 0.01);
  EXPECT_EQ(space.most[2], 0) << "Z does not move";
  EXPECT_NEAR(std::abs(space.at[1]), 100, 0.01);
  EXPECT_NEAR(space.u.x() / (100 * u), 1, 1e-3);
  EXPECT_EQ(space.u.y(), 0);
  EXPECT_EQ(space.u.z(), 0);
  EXPECT_NEAR(space.rms / (100 * u), std::sqrt(5.0 / 12), 1e-3);
}

// Radially, at the tested circle, it is what the prediction of a trace says.
TEST(DeviationUncertainty, AgreesWithThePredictionOfATrace) {
  const Machine machine = machine_of(kMill);
  const std::vector<BallbarTest> tests = {measured(machine, {{0, 1}, 100, 20, 360})};
  const Identification found = identifiability(machine, tests, only_squareness());
  const TracePrediction trace = predict_trace(machine, found, tests[0], 0);
  const DeviationUncertainty space = uncertainty_of_deviation(machine, found, tests);
  // Radially -EC0Y y x / R, most at 45 degrees: half of the worst displacement.
  EXPECT_NEAR(2 * *std::max_element(trace.uncertainty.begin(), trace.uncertainty.end()) / space.worst, 1,
              1e-3);
}

TEST(DeviationUncertainty, MoreSamplesLessUncertainty) {
  const Machine machine = machine_of(kMill);
  IdentifyOptions options;
  options.terms = {1, 2, 0, true, true, false, false, false, false};
  const auto worst = [&](int samples) {
    const std::vector<BallbarTest> tests = {measured(machine, {{0, 1}, 100, 20, samples, 0, 360, "s"}),
                                            measured(machine, {{0, 1}, 150, 60, samples, 0, 360, "s"}),
                                            measured(machine, {{2, 0}, 100, 20, samples, -20, 200})};
    return uncertainty_of_deviation(machine, identifiability(machine, tests, options), tests);
  };
  const DeviationUncertainty few = worst(200), many = worst(800);
  // Half, but for the samples left out near reversals.
  EXPECT_NEAR(many.worst / few.worst, 0.5, 0.05);
  EXPECT_LT(many.rms, many.worst);
  EXPECT_GT(few.u.z(), 0) << "ZX moved Z";
}

}  // namespace
}  // namespace abbe
