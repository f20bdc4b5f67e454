#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "abbe/signal/align.h"
#include "abbe/signal/differentiate.h"
#include "abbe/signal/fit_figures.h"
#include "abbe/signal/resample.h"
#include "abbe/signal/sine_fit.h"
#include "abbe/signal/smooth.h"
#include "abbe/signal/test_golden.h"

namespace abbe {
namespace {

using testing::DoubleNear;
using testing::Pointwise;

constexpr double kRounding = 1e-12;
constexpr double kGolden = 1e-9;
constexpr double kPi = std::numbers::pi;
const double kNan = std::numeric_limits<double>::quiet_NaN();

template <class T>
T value_of(SignalResult<T> result) {
  EXPECT_TRUE(std::holds_alternative<T>(result));
  return std::holds_alternative<T>(result) ? std::get<T>(result) : T{};
}

template <class T>
SignalProblem problem_of(const SignalResult<T>& result) {
  EXPECT_TRUE(std::holds_alternative<SignalProblem>(result));
  return std::holds_alternative<SignalProblem>(result) ? std::get<SignalProblem>(result)
                                                       : SignalProblem::constant;
}

Samples random_samples(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Samples y(n);
  for (double& v : y) v = normal(random);
  return y;
}

Samples made_of(std::size_t n, const std::function<double(double)>& f) {
  Samples y(n);
  for (std::size_t i = 0; i < n; ++i) y[i] = f(static_cast<double>(i));
  return y;
}

TEST(FivePointSmooth, CubicsPass) {
  const Samples y = made_of(9, [](double t) { return 1 - 2 * t + 0.5 * t * t - 0.25 * t * t * t; });
  EXPECT_THAT(value_of(five_point_smooth(y, 3)), Pointwise(DoubleNear(1e-11), y));
}

TEST(FivePointSmooth, IsSavitzkyGolay) {
  const Samples y = random_samples(40, 1);
  EXPECT_THAT(value_of(five_point_smooth(y)),
              Pointwise(DoubleNear(kRounding), value_of(savitzky_golay(y, {5, 3, 0, 1}))));
}

// Computed from the equations of seed 004: weights 69, 4, -6, 4, -1 over 70 and so on, of a unit pulse.
TEST(FivePointSmooth, PulseShowsTheWeights) {
  const Samples pulse = {1, 0, 0, 0, 0, 0};
  const Samples smooth = value_of(five_point_smooth(pulse));
  EXPECT_THAT(smooth, Pointwise(DoubleNear(kRounding), Samples{69.0 / 70, 2.0 / 35, -3.0 / 35, 0, 0, 0}));
}

TEST(FivePointSmooth, PassesRepeat) {
  const Samples y = random_samples(30, 2);
  EXPECT_EQ(value_of(five_point_smooth(y, 0)), y);
  EXPECT_EQ(value_of(five_point_smooth(y, 2)), value_of(five_point_smooth(value_of(five_point_smooth(y)))));
}

TEST(SavitzkyGolay, PolynomialsAreExact) {
  const double dt = 0.01;
  const auto f = [](double t) { return 3 + t - 2 * t * t + 4 * t * t * t; };
  const auto df = [](double t) { return 1 - 4 * t + 12 * t * t; };
  const auto ddf = [](double t) { return -4 + 24 * t; };
  const Samples y = made_of(50, [&](double i) { return f(i * dt); });
  for (const int window : {5, 11, 49}) {
    const Samples first = value_of(savitzky_golay(y, {window, 4, 1, dt}));
    const Samples second = value_of(savitzky_golay(y, {window, 3, 2, dt}));
    for (std::size_t i = 0; i < y.size(); ++i) {
      const double t = static_cast<double>(i) * dt;
      ASSERT_NEAR(first[i], df(t), 1e-9) << window << ' ' << i;
      ASSERT_NEAR(second[i], ddf(t), 1e-6) << window << ' ' << i;
    }
  }
}

TEST(Differentiate, ParabolasAreExact) {
  const double dt = 0.5;
  const Samples y = made_of(6, [&](double i) { return 2 + 3 * i * dt - 4 * i * dt * i * dt; });
  const Samples should = made_of(6, [&](double i) { return 3 - 8 * i * dt; });
  EXPECT_THAT(value_of(differentiate(y, dt)), Pointwise(DoubleNear(kRounding), should));
}

TEST(Interpolate, NodesAreKept) {
  const Samples x = {0, 0.3, 1, 1.5, 4, 4.2}, y = random_samples(6, 4);
  for (const Interpolation kind : {Interpolation::linear, Interpolation::cubic})
    EXPECT_THAT(value_of(interpolate(x, y, x, kind)), Pointwise(DoubleNear(kRounding), y));
}

TEST(Interpolate, CubicsAreExact) {
  const auto f = [](double t) { return 1 + t - t * t + 0.3 * t * t * t; };
  const Samples x = {-1, -0.4, 0, 1, 1.5, 2.5, 3};
  Samples y, at = {3, -1, 2.9, -0.99, 0.5, 1.2, 0.1}, should;
  for (const double t : x) y.push_back(f(t));
  for (const double t : at) should.push_back(f(t));
  EXPECT_THAT(value_of(interpolate(x, y, at, Interpolation::cubic)),
              Pointwise(DoubleNear(kRounding), should));
  EXPECT_THAT(value_of(interpolate(Samples{0, 2}, Samples{1, 5}, Samples{0.5}, Interpolation::cubic)),
              Pointwise(DoubleNear(kRounding), Samples{2}));
}

TEST(Resample, GridReachesTheEnd) {
  const Samples x = {0, 0.4, 1}, y = {0, 4, 10};
  const UniformRecord record = value_of(resample(x, y, 0.1, Interpolation::linear));
  ASSERT_EQ(record.samples.size(), 11U);
  EXPECT_NEAR(record.samples[7], 7, kRounding);
  EXPECT_NEAR(record.samples[10], 10, kRounding);
}

TEST(FindDelay, ShiftIsFound) {
  const Samples wave =
      made_of(500, [](double i) { return std::sin(i / 9) + 0.4 * std::cos(i / 3.7 + 0.01 * i * i / 50); });
  const Samples a(wave.begin() + 40, wave.begin() + 400), b(wave.begin() + 17, wave.begin() + 380);
  // b_i = wave_{i+17}, a_i = wave_{i+40}: what a shows at i, b shows at i + 23.
  const Delay delay = value_of(find_delay(a, b));
  EXPECT_NEAR(delay.samples, 23, 0.01);
  EXPECT_GT(delay.coefficient, 0.999);
}

TEST(FindDelay, FractionIsFound) {
  const auto f = [](double t) { return std::exp(-(t - 100) * (t - 100) / 400) + 0.1 * std::sin(t / 8); };
  const Samples a = made_of(250, f), b = made_of(250, [&](double t) { return f(t - 3.3); });
  EXPECT_NEAR(value_of(find_delay(a, b)).samples, 3.3, 0.02);
}

TEST(FindDelay, NoiseOnABroadPeakDoesNotPullTowardsZero) {
  // Two turns of 1000 samples, noise of 5 %: ripples of r between 0 and the delay are as high as its peak.
  constexpr double kDelay = 6, kNoise = 0.05;
  constexpr int kRecords = 20;
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, kNoise);
  double sum = 0;
  for (int record = 0; record < kRecords; ++record) {
    Samples a, b;
    for (int i = 0; i < 2000; ++i) {
      a.push_back(std::sin(2 * kPi * i / 1000) + noise(random));
      b.push_back(std::sin(2 * kPi * (i - kDelay) / 1000) + noise(random));
    }
    sum += value_of(find_delay(a, b)).samples;
  }
  EXPECT_NEAR(sum / kRecords, kDelay, 1);
}

TEST(FindDelay, ExchangeChangesTheSign) {
  const Samples wave = random_samples(400, 9);
  const Samples a(wave.begin(), wave.begin() + 300), b(wave.begin() + 31, wave.end());
  EXPECT_NEAR(value_of(find_delay(a, b)).samples, -31, 0.2);
  EXPECT_NEAR(value_of(find_delay(b, a)).samples, 31, 0.2);
}

TEST(AlignByAngle, AnglesAreFoundWhereTheyWere) {
  for (const double sense : {1.0, -1.0}) {
    // Run-in at rest, a turn and a half, then back a little.
    Samples x, y;
    const auto push = [&](double angle) {
      x.push_back(10 + 100 * std::cos(sense * angle));
      y.push_back(-5 + 100 * std::sin(sense * angle));
    };
    for (int i = 0; i < 50; ++i) push(0);
    for (int i = 1; i <= 300; ++i) push(i * 0.0314);
    for (int i = 1; i < 20; ++i) push(300 * 0.0314 - i * 0.0314);
    const Samples record = value_of(unwrapped_angles(x, y, 10, -5));
    const Samples wanted = {sense * (0.1 + 2 * kPi), sense * (0.5 + 2 * kPi), sense * (6.0 + 2 * kPi)};
    const AngleAlignment alignment = value_of(align_by_angle(record, wanted));
    EXPECT_EQ(alignment.turns, sense > 0 ? -1 : 1);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const double passed = (std::abs(wanted[i]) - 2 * kPi) / 0.0314 + 49;
      EXPECT_NEAR(alignment.index[i], passed, 1e-6) << sense << ' ' << i;
    }
  }
}

TEST(AlignByAngle, WhatWasNotPassedIsRefused) {
  const Samples record = made_of(100, [](double i) { return 0.01 * i; });
  EXPECT_EQ(problem_of(align_by_angle(record, Samples{0.5, 1.2})), SignalProblem::no_overlap);
  EXPECT_EQ(problem_of(align_by_angle(Samples{1, 1, 1}, Samples{1})), SignalProblem::constant);
}

TEST(FitSine, SinesAreFound) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(0, 1);
  for (int run = 0; run < 40; ++run) {
    const Sine truth = {std::pow(10, 4 * part(random) - 3), 0.4 + 30 * part(random),
                        kPi * (2 * part(random) - 1), part(random) - 0.5};
    Samples t, y;
    for (int i = 0; i < 300; ++i) {
      t.push_back(7 + 0.03 * i + (run % 2 == 0 ? 0 : 0.01 * part(random)));
      y.push_back(truth.at(t.back()));
    }
    const SineFit fit = value_of(fit_sine(t, y));
    EXPECT_NEAR(fit.sine.omega, truth.omega, 1e-7) << run;
    EXPECT_NEAR(fit.sine.amplitude / truth.amplitude, 1, 1e-6) << run;
    EXPECT_NEAR(std::remainder(fit.sine.phase - truth.phase, 2 * kPi), 0, 1e-6) << run;
    EXPECT_NEAR(fit.sine.offset, truth.offset, 1e-6 * (1 + truth.amplitude)) << run;
  }
}

TEST(FitSine, UncertaintyCoversTheTruth) {
  const Sine truth = {2, 1.3, 0.7, 0.1};
  int covered = 0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    const Samples noise = random_samples(200, 100 + static_cast<unsigned>(run));
    Samples t, y;
    for (std::size_t i = 0; i < noise.size(); ++i) {
      t.push_back(0.1 * static_cast<double>(i));
      y.push_back(truth.at(t.back()) + 0.05 * noise[i]);
    }
    const SineFit fit = value_of(fit_sine(t, y));
    if (std::abs(fit.sine.phase - truth.phase) <= 1.96 * fit.uncertainty.phase) ++covered;
  }
  EXPECT_GE(covered, 180);  // 95 % of 200 less 3 standard deviations
  EXPECT_LE(covered, 199);
}

TEST(FitFigures, HandCalculated) {
  const FitFigures f = value_of(fit_figures(Samples{1, 2, 3, 4}, Samples{1, 2, 3, 6}, 2));
  EXPECT_DOUBLE_EQ(f.sse, 4);
  EXPECT_DOUBLE_EQ(f.sst, 5);
  EXPECT_DOUBLE_EQ(*f.r2, 0.2);
  EXPECT_DOUBLE_EQ(f.rmse, 1);
  EXPECT_DOUBLE_EQ(*f.rmse_freedom, std::sqrt(2.0));
  EXPECT_FALSE(value_of(fit_figures(Samples{1, 1}, Samples{1, 2})).r2);
  EXPECT_FALSE(value_of(fit_figures(Samples{1, 2}, Samples{1, 2}, 2)).rmse_freedom);
}

TEST(Signal, EqualsTheGoldenNumbers) {
  const auto golden = golden_signal();
  if (!golden) GTEST_SKIP() << "no ../shared/golden/seed004_signal.json";
  const auto& g = *golden;
  const Samples smooth_input = g["smooth53"]["input"], smooth_output = g["smooth53"]["output"];
  EXPECT_THAT(value_of(five_point_smooth(smooth_input)), Pointwise(DoubleNear(kGolden), smooth_output));

  const auto& d = g["differentiate"];
  const Samples position = d["pos"], velocity = d["vel"], acceleration = d["acc"];
  const Samples v = value_of(differentiate(position, d["dt"]));
  EXPECT_THAT(v, Pointwise(DoubleNear(kGolden), velocity));
  EXPECT_THAT(value_of(differentiate(v, d["dt"])), Pointwise(DoubleNear(kGolden), acceleration));

  const Samples y = g["gof"]["y"], f = g["gof"]["yhat"];
  const FitFigures figures = value_of(fit_figures(y, f, g["gof"]["params"]));
  const auto& expected = g["gof"]["result"];
  EXPECT_NEAR(figures.sse, expected["SSE"], kGolden);
  EXPECT_NEAR(*figures.r2, expected["R2"], kGolden);
  EXPECT_NEAR(figures.rmse, expected["RMSE_n"], kGolden);
  EXPECT_NEAR(*figures.rmse_freedom, expected["RMSE_dof"], kGolden);
  EXPECT_NEAR(*figures.adjusted_r2, expected["adjR2"], kGolden);

  const Samples t = g["sin_fit"]["t"], wave = g["sin_fit"]["y"];
  const SineFit fit = value_of(fit_sine(t, wave));
  EXPECT_NEAR(fit.sine.amplitude, g["sin_fit"]["A"], kGolden);
  EXPECT_NEAR(fit.sine.omega, g["sin_fit"]["w"], kGolden);
  EXPECT_NEAR(fit.sine.phase, g["sin_fit"]["phi"], kGolden);
  EXPECT_NEAR(fit.sine.offset, g["sin_fit"]["c"], kGolden);
  EXPECT_NEAR(fit.sse, g["sin_fit"]["SSE"], kGolden);
}

TEST(Signal, BadInputIsNamed) {
  const Samples four = {1, 2, 3, 4}, bad = {1, kNan, 2, 3, 4, 5}, six = {0, 1, 2, 3, 4, 5}, flat(6, 2.5);
  EXPECT_EQ(problem_of(five_point_smooth(four)), SignalProblem::too_short);
  EXPECT_EQ(problem_of(five_point_smooth(bad)), SignalProblem::not_finite);
  EXPECT_EQ(problem_of(five_point_smooth(six, -1)), SignalProblem::bad_option);
  EXPECT_EQ(problem_of(savitzky_golay(six, {4, 2, 0, 1})), SignalProblem::bad_option);
  EXPECT_EQ(problem_of(savitzky_golay(six, {5, 5, 0, 1})), SignalProblem::bad_option);
  EXPECT_EQ(problem_of(savitzky_golay(six, {5, 3, 1, 0})), SignalProblem::bad_option);
  EXPECT_EQ(problem_of(savitzky_golay(six, {7, 3, 0, 1})), SignalProblem::too_short);
  EXPECT_EQ(problem_of(differentiate(Samples{1, 2}, 1)), SignalProblem::too_short);
  EXPECT_EQ(problem_of(differentiate(six, kNan)), SignalProblem::bad_option);
  EXPECT_EQ(problem_of(interpolate(flat, six, six, Interpolation::linear)), SignalProblem::not_increasing);
  EXPECT_EQ(problem_of(interpolate(six, six, Samples{5.1}, Interpolation::linear)),
            SignalProblem::no_overlap);
  EXPECT_EQ(problem_of(interpolate(six, four, six, Interpolation::linear)), SignalProblem::sizes_differ);
  EXPECT_EQ(problem_of(resample(six, six, 0)), SignalProblem::bad_option);
  EXPECT_EQ(problem_of(resample(six, six, 1e-12)), SignalProblem::bad_option);
  EXPECT_EQ(problem_of(find_delay(flat, flat)), SignalProblem::constant);
  EXPECT_EQ(problem_of(find_delay(six, Samples{1})), SignalProblem::too_short);
  EXPECT_EQ(problem_of(fit_sine(six, flat)), SignalProblem::constant);
  EXPECT_EQ(problem_of(fit_sine(flat, six)), SignalProblem::not_increasing);
  EXPECT_EQ(problem_of(fit_sine(four, four)), SignalProblem::too_short);
  EXPECT_EQ(problem_of(fit_figures(six, four)), SignalProblem::sizes_differ);
  EXPECT_EQ(problem_of(unwrapped_angles(six, bad, 0, 0)), SignalProblem::not_finite);
}

}  // namespace
}  // namespace abbe
