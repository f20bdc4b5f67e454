#include "abbe/ballbar/diagnosis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "abbe/ballbar/circular_figures.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

using Kind = DiagnosisTerm::Kind;

constexpr double kExact = 1e-9;        // relative: rounding through the fit
constexpr double kThreeDigits = 6e-4;  // um: numbers known to three decimals

/// A test of both directions whose deviation is f(t, s) every 0.1 deg. It begins half a step behind zero, so
/// that no sample is at a reversal.
BallbarTest test_of(const std::function<double(double, int)>& f, double noise = 0, double first = 0.5) {
  constexpr int count = 3600;
  BallbarTest test;
  test.radius = 150;
  test.feed = 1000.0 / 60;
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  for (const int s : {+1, -1}) {
    BallbarRun run;
    run.direction = s;
    for (int i = 0; i < count; ++i) {
      const double t = s * (i + first) * 2 * std::numbers::pi / count;
      run.angle.push_back(t);
      run.deviation.push_back(f(t, s) + noise * normal(random));
    }
    test.runs.push_back(run);
  }
  return test;
}

// um: steps of 10 um at the reversals; which side the sample at the step belongs to moves means by a 3600th
// of them.
constexpr double kOneSample = 5e-3;

double sgn(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

/// R 150 mm, v 1000 mm/min: centre (3, -2) um, squareness 20 urad, scales (30, -10) um/m, lags (1.0, 1.4) ms,
/// backlash (6, 4) um, straightness of X 2e-7 /mm.
double worked(double t, int s) {
  const double R = 150, v = 1000.0 / 60, c = std::cos(t), w = std::sin(t);
  const double x = R * c;
  return 3 * um * c - 2 * um * w + R * (30e-6 * c * c - 10e-6 * w * w) - 20e-6 * R / 2 * std::sin(2 * t) +
         s * v / 2 * (1.0e-3 - 1.4e-3) * std::sin(2 * t) - 3 * um * sgn(-s * w) * c -
         2 * um * sgn(s * c) * w + 2e-7 * x * x * w;
}

void expect_term(const Diagnosis& d, Kind kind, const char* axis, double wanted, double tolerance) {
  const DiagnosisTerm* term = d.find(kind, axis);
  ASSERT_NE(term, nullptr) << to_string(kind) << axis;
  EXPECT_NEAR(term->value, wanted, tolerance) << to_string(kind) << axis;
}

TEST(Diagnosis, WorkedExampleIsReturnedExactly) {
  const BallbarTest test = test_of(worked);
  const Diagnosis d = diagnose(test);
  ASSERT_TRUE(d.solved);
  expect_term(d, Kind::centre, "X", 3 * um, kExact * um);
  expect_term(d, Kind::centre, "Y", -2 * um, kExact * um);
  expect_term(d, Kind::squareness, "", 20 * urad, kExact * urad);
  expect_term(d, Kind::scale_mismatch, "", 40e-6, kExact * 1e-6);
  expect_term(d, Kind::radius, "", 150 * 10e-6, kExact * um);
  expect_term(d, Kind::servo_mismatch, "", -0.4e-3, kExact * 1e-3);
  expect_term(d, Kind::backlash, "X", 6 * um, kExact * um);
  expect_term(d, Kind::backlash, "Y", 4 * um, kExact * um);
  expect_term(d, Kind::straightness, "X", 2e-7, kExact * 1e-7);
  expect_term(d, Kind::straightness, "Y", 0, kExact * 1e-7);
  expect_term(d, Kind::lateral_play, "X", 0, kExact * um);
  EXPECT_LT(d.residuals.rms, kExact * um);
  for (const DiagnosisTerm& term : d.terms) EXPECT_TRUE(term.separable) << to_string(term.kind);
}

TEST(Diagnosis, FiguresOfTheWorkedExample) {
  const TestFigures f = circular_figures(test_of(worked, 0, 0));
  EXPECT_NEAR(f.directions[0].least_squares.width() / um, 12.954, kOneSample);
  EXPECT_NEAR(f.directions[1].least_squares.width() / um, 12.133, kOneSample);
  EXPECT_NEAR(f.least_squares_both.width() / um, 12.969, kOneSample);
  EXPECT_NEAR(f.mean_radial_deviation / um, 1.502, kOneSample);
}

TEST(Diagnosis, BacklashDoesNotLeakIntoServoMismatch) {
  const Diagnosis d = diagnose(test_of(worked));
  EXPECT_NEAR(d.harmonic_only_servo * 1e3, -0.298, kThreeDigits);
  EXPECT_NEAR(d.find(Kind::servo_mismatch)->value * 1e3, -0.4, kExact);
}

TEST(Diagnosis, TermHasItsSign) {
  const auto alone = [&](Kind kind, const char* axis, double value,
                         const std::function<double(double, int)>& f) {
    const Diagnosis d = diagnose(test_of(f));
    expect_term(d, kind, axis, value, 1e-6 * std::abs(value));
    for (const DiagnosisTerm& term : d.terms) {
      if (term.kind != kind || term.axis != axis) {
        EXPECT_LT(term.effect, 1e-6 * um) << to_string(term.kind);
      }
    }
  };
  alone(Kind::lateral_play, "X", 2 * um,
        [](double t, int s) { return um * sgn(-s * std::sin(t)) * std::sin(t); });
  alone(Kind::lateral_play, "Y", 2 * um,
        [](double t, int s) { return um * sgn(s * std::cos(t)) * std::cos(t); });
  alone(Kind::straightness, "Y", 1e-7,
        [](double t, int) { return 1e-7 * std::pow(150 * std::sin(t), 2) * std::cos(t); });
}

TEST(Diagnosis, CyclicErrorAndItsPitchAreFound) {
  const auto f = [](double t, int s) {
    return worked(t, s) +
           0.8 * um * std::sin(2 * std::numbers::pi * 150 * std::cos(t) / 5 + 0.7) * std::cos(t);
  };
  const Diagnosis d = diagnose(test_of(f, 0.1 * um));
  ASSERT_TRUE(d.pitch[0]);
  EXPECT_TRUE(d.pitch_found[0]);
  EXPECT_FALSE(d.pitch[1]);
  EXPECT_NEAR(*d.pitch[0], 5, 2e-3);
  const double s = d.find(Kind::cyclic_sine, "X")->value, c = d.find(Kind::cyclic_cosine, "X")->value;
  EXPECT_NEAR(std::hypot(s, c) / um, 0.8, 0.02);
  EXPECT_TRUE(d.residuals.white);
  EXPECT_FALSE(diagnose(test_of(f, 0.1 * um), {{}, false, true}).residuals.white);
  EXPECT_NEAR(
      std::atan2(
          diagnose(test_of(f, 0), {{5.0, std::nullopt}, true, true}).find(Kind::cyclic_cosine, "X")->value,
          diagnose(test_of(f, 0), {{5.0, std::nullopt}, true, true}).find(Kind::cyclic_sine, "X")->value),
      0.7, 1e-6);
}

// Of a dozen samples twelve causes explain all; a wave more fits them whatever they are.
TEST(Diagnosis, FewSamplesShowNoCyclicError) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1 * um);
    BallbarTest test;
    test.radius = 150;
    test.feed = 1000.0 / 60;
    BallbarRun run;
    for (int i = 0; i < 12 + static_cast<int>(seed) / 2; ++i) {
      run.angle.push_back((i + 0.5) * 25 * deg);
      run.deviation.push_back(normal(random));
    }
    test.runs = {run};
    const Diagnosis d = diagnose(test, {});
    EXPECT_FALSE(d.pitch_found[0] || d.pitch_found[1]) << seed;
    EXPECT_FALSE(d.spike_time) << seed;
    EXPECT_LT(d.spare, kFewestSpare);
  }
}

TEST(Diagnosis, ReversalSpikesHaveHeightAndDuration) {
  constexpr double kTime = 0.05, kHeight = 3 * um;  // after X reverses at its positive end
  const auto f = [](double t, int s) {
    double since = std::fmod(s * t, 2 * std::numbers::pi);
    if (since < 0) since += 2 * std::numbers::pi;
    return kHeight * std::exp(-since * 150 / (1000.0 / 60) / kTime);
  };
  const Diagnosis d = diagnose(test_of(f, 0.1 * um));
  ASSERT_TRUE(d.spike_time);
  EXPECT_NEAR(*d.spike_time / kTime, 1, 0.3);  // of a grid
  EXPECT_NEAR(d.find(Kind::spike, "X+")->value / um, 3, 0.5);
  EXPECT_NEAR(d.find(Kind::spike, "Y-")->value / um, 0, 0.2);
  EXPECT_FALSE(diagnose(test_of(worked, 0.1 * um)).spike_time);
}

TEST(Diagnosis, SamplesAtReversalsAreLeftOut) {
  const Diagnosis d = diagnose(test_of(worked, 0.1 * um, 0));
  EXPECT_FALSE(d.spike_time);
  EXPECT_LT(d.residuals.largest, 0.6 * um);
}

TEST(Diagnosis, UncertaintyCoversTheTruth) {
  const Diagnosis d = diagnose(test_of(worked, 0.2 * um));
  const DiagnosisTerm* b = d.find(Kind::backlash, "X");
  EXPECT_GT(b->uncertainty, 0);
  EXPECT_LT(b->uncertainty, 0.05 * um);
  EXPECT_NEAR(b->value, 6 * um, 4 * b->uncertainty);
  EXPECT_NEAR(d.find(Kind::squareness)->value, 20 * urad, 4 * d.find(Kind::squareness)->uncertainty);
}

TEST(Diagnosis, OneDirectionCannotSeparateServoMismatchFromSquareness) {
  BallbarTest test = test_of(worked);
  test.runs.pop_back();
  const Diagnosis d = diagnose(test);
  ASSERT_TRUE(d.solved);
  EXPECT_FALSE(d.find(Kind::servo_mismatch)->separable);
  EXPECT_FALSE(d.find(Kind::squareness)->separable);
  EXPECT_EQ(d.find(Kind::squareness)->uncertainty, 0);
  expect_term(d, Kind::scale_mismatch, "", 40e-6, 1e-12);
}

TEST(Diagnosis, PlanesNameTheirAxes) {
  BallbarTest test = test_of(worked);
  test.plane = *read_plane("ZX");
  const Diagnosis d = diagnose(test);
  expect_term(d, Kind::backlash, "Z", 6 * um, kExact * um);
  expect_term(d, Kind::backlash, "X", 4 * um, kExact * um);
}

}  // namespace
}  // namespace abbe
