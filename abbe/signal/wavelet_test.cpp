#include "abbe/signal/wavelet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "abbe/signal/denoise.h"
#include "abbe/signal/test_golden.h"

namespace abbe {
namespace {

constexpr double kRounding = 1e-12;
constexpr double kTapRounding = 2e-11;  // the published taps of long filters are that good
constexpr double kGolden = 1e-9;        // stated with the golden numbers

Samples noise(std::size_t n, unsigned seed, double sigma = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sigma);
  Samples y(n);
  for (double& v : y) v = normal(random);
  return y;
}

template <class T>
T value_of(SignalResult<T> result) {
  EXPECT_TRUE(std::holds_alternative<T>(result)) << to_string(
      std::get_if<SignalProblem>(&result) ? std::get<SignalProblem>(result) : SignalProblem::bad_option);
  return std::holds_alternative<T>(result) ? std::get<T>(result) : T{};
}

TEST(Wavelet, FiltersAreOrthonormal) {
  for (const std::string& name : wavelet_names()) {
    const auto wavelet = find_wavelet(name);
    ASSERT_TRUE(wavelet) << name;
    const auto g = wavelet->scaling;
    double sum = 0;
    for (const double tap : g) sum += tap;
    EXPECT_NEAR(sum, std::numbers::sqrt2, kTapRounding) << name;
    for (std::size_t k = 0; 2 * k < g.size(); ++k) {
      double product = 0;
      for (std::size_t j = 0; j + 2 * k < g.size(); ++j) product += g[j] * g[j + 2 * k];
      EXPECT_NEAR(product, k == 0 ? 1 : 0, kTapRounding) << name << " shift " << k;
    }
    // Vanishing moments of the high-pass: at least the first three, where rounding lets them be seen.
    for (int moment = 0; moment < static_cast<int>(g.size() / 2) && moment < 3; ++moment) {
      double total = 0, size = 0;
      for (std::size_t j = 0; j < g.size(); ++j) {
        const double term = (j % 2 == 0 ? 1 : -1) * g[j] * std::pow(static_cast<double>(j), moment);
        total += term;
        size += std::abs(term);
      }
      EXPECT_NEAR(total, 0, 1e-10 * size) << name << " moment " << moment;
    }
  }
  EXPECT_EQ(find_wavelet("haar")->scaling.size(), 2U);
  for (const char* wrong : {"", "db", "db0", "db21", "sym1", "sym", "db05", "coif1", "db 5", "sym5 "})
    EXPECT_FALSE(find_wavelet(wrong)) << wrong;
}

TEST(Wavelet, StepsInvert) {
  for (const char* name : {"db1", "db2", "sym5", "db10", "sym20"}) {
    const Wavelet wavelet = *find_wavelet(name);
    for (const std::size_t n : {1U, 2U, 3U, 7U, 9U, 10U, 64U, 999U, 2047U, 2048U, 2049U, 5000U}) {
      const Samples x = noise(n, 7 + static_cast<unsigned>(n));
      const WaveletStep step = value_of(dwt(x, wavelet));
      EXPECT_EQ(step.low.size(), (n + wavelet.scaling.size() - 1) / 2);
      const Samples back = value_of(inverse_dwt(step.low, step.high, wavelet, n));
      ASSERT_EQ(back.size(), n);
      for (std::size_t i = 0; i < n; ++i) ASSERT_NEAR(back[i], x[i], 1e-10) << name << ' ' << n << ' ' << i;
    }
  }
}

TEST(Wavelet, LevelsInvert) {
  const Wavelet wavelet = *find_wavelet("sym5");
  const Samples x = noise(777, 3);
  for (int levels = 1; levels <= 9; ++levels) {
    const Decomposition parts = value_of(decompose(x, wavelet, levels));
    EXPECT_EQ(parts.details.size(), static_cast<std::size_t>(levels));
    EXPECT_THAT(value_of(reconstruct(parts, wavelet)), testing::Pointwise(testing::DoubleNear(1e-11), x));
  }
}

// Computed with PyWavelets 1.1.1: wavedec of x_i = ((37 i + 11) mod 29) / 7 - 2 + 0.01 i, mode "symmetric".
TEST(Wavelet, CoefficientsAreThoseOfPyWavelets) {
  Samples x;
  for (int i = 0; i < 21; ++i) x.push_back(((i * 37 + 11) % 29) / 7.0 - 2.0 + 0.01 * i);
  struct Case {
    const char* name;
    int levels;
    std::vector<double> approximation, finest;
    double finest_last, coarsest_first;
  };
  const std::vector<Case> cases = {
      {"db4",
       2,
       {0.5400314793487758, 1.0146151738077571, -0.2802371298685092},
       {0.0796995544327222, 1.0455493249913772, 0.5320027583601525},
       -0.5943467539262636,
       -0.598799833450123},
      {"sym8",
       3,
       {0.6294278118351646, 0.5307271526960474, 0.7183960520974508},
       {1.247502228950859, 0.2779900047560913, -1.9691279264195822},
       2.055503298312117,
       1.0343422549312977},
      {"db1",
       3,
       {-0.052527932316714765, 1.1333911549875808, 2.8031733111323858},
       {-0.8151931034536343, 2.114249275747777, -0.8151931034536342},
       0.0,
       0.8020611203744556},
  };
  for (const Case& c : cases) {
    const Decomposition parts = value_of(decompose(x, *find_wavelet(c.name), c.levels));
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(parts.approximation[i], c.approximation[i], kRounding) << c.name;
      EXPECT_NEAR(parts.details.front()[i], c.finest[i], kRounding) << c.name;
    }
    EXPECT_NEAR(parts.details.front().back(), c.finest_last, kRounding) << c.name;
    EXPECT_NEAR(parts.details.back().front(), c.coarsest_first, kRounding) << c.name;
  }
}

TEST(Wavelet, UsefulLevelsAreThoseOfPyWavelets) {
  EXPECT_EQ(useful_levels(512, *find_wavelet("sym5")), 5);
  EXPECT_EQ(useful_levels(9, *find_wavelet("sym5")), 0);
  EXPECT_EQ(useful_levels(18, *find_wavelet("sym5")), 1);
  EXPECT_EQ(useful_levels(1024, *find_wavelet("db1")), 10);
}

TEST(Wavelet, BadInputIsNamed) {
  const Wavelet wavelet = *find_wavelet("sym5");
  const auto problem = [](const auto& result) { return std::get<SignalProblem>(result); };
  const Samples none, one = {1}, bad = {1, std::numeric_limits<double>::quiet_NaN(), 2};
  EXPECT_EQ(problem(dwt(none, wavelet)), SignalProblem::too_short);
  EXPECT_EQ(problem(dwt(bad, wavelet)), SignalProblem::not_finite);
  EXPECT_EQ(problem(decompose(one, wavelet, 0)), SignalProblem::bad_option);
  EXPECT_EQ(problem(decompose(one, wavelet, kMostLevels + 1)), SignalProblem::bad_option);
  EXPECT_EQ(problem(inverse_dwt(one, one, wavelet, 100)), SignalProblem::sizes_differ);
  EXPECT_EQ(problem(denoise(one, wavelet)), SignalProblem::too_short);
  EXPECT_EQ(problem(denoise(Samples{0, 1e101}, wavelet)), SignalProblem::not_finite);
}

TEST(Denoise, MedianIsThatOfSorting) {
  for (const std::size_t n : {1U, 2U, 3U, 10U, 11U, 1000U, 4097U}) {
    Samples v = noise(n, static_cast<unsigned>(n), 1e-3);
    if (n > 5) v[3] = v[4] = 0;
    Samples sorted;
    for (const double value : v) sorted.push_back(std::abs(value));
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(median_magnitude(v), n % 2 == 1 ? sorted[n / 2] : (sorted[n / 2 - 1] + sorted[n / 2]) / 2) << n;
  }
  EXPECT_EQ(median_magnitude(Samples{}), 0);
}

TEST(Denoise, NothingIsLostBelowZeroThreshold) {
  // More than half of the finest details of a record of jumps are zero: sigma, and with it T, is 0.
  Samples steps(256);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = i < 100 ? 1.5 : -2;
  const Denoised result = value_of(denoise(steps, *find_wavelet("db1")));
  EXPECT_EQ(result.threshold.front(), 0);
  EXPECT_THAT(result.samples, testing::Pointwise(testing::DoubleNear(kRounding), steps));
}

TEST(Denoise, SoftShrinksTowardsZero) {
  const Samples y = noise(500, 11);
  DenoiseOptions options;
  options.sigma = DenoiseOptions::Sigma::one;
  options.threshold = DenoiseOptions::Threshold::soft;
  const double t = std::sqrt(2 * std::log(500.0));
  Samples tall = y;
  for (std::size_t i = 0; i < tall.size(); ++i) tall[i] += i == 250 ? 50 : 0;
  const Denoised result = value_of(denoise(tall, *find_wavelet("sym5"), options));
  EXPECT_NEAR(result.threshold.front(), t, kRounding);
  // Per detail at most T is taken away, so the spike stays, but lower.
  EXPECT_GT(result.samples[250], 10);
  EXPECT_LT(result.samples[250], 50);
}

TEST(Denoise, EqualsTheGoldenNumbers) {
  const auto golden = golden_signal();
  if (!golden) GTEST_SKIP() << "no ../shared/golden/seed004_signal.json";
  const auto& g = (*golden)["wavelet"];
  const Samples x = g["input"];
  const Wavelet sym5 = *find_wavelet("sym5");
  const auto near = [&](const Samples& is, const Samples& should, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) ASSERT_NEAR(is[i], should[i], kGolden) << i;
  };
  const WaveletStep step = value_of(dwt(x, sym5));
  near(step.low, g["dwt1_a_first8"], 8);
  near(step.high, g["dwt1_d_first8"], 8);
  const Decomposition parts = value_of(decompose(x, sym5, 5));
  near(parts.approximation, g["a5"], 24);
  EXPECT_EQ(parts.details.back().size(), 24U);
  EXPECT_EQ(parts.coefficients(), 553U);

  const Denoised sln = value_of(denoise(x, sym5));
  EXPECT_NEAR(sln.sigma.front(), g["sigma_sln"], kGolden);
  EXPECT_NEAR(sln.threshold.front(), g["threshold_sln"], kGolden);
  EXPECT_THAT(sln.kept, testing::ElementsAre(0, 1, 0, 1, 9));
  near(sln.samples, g["denoised_sln"], 512);

  DenoiseOptions options;
  options.sigma = DenoiseOptions::Sigma::per_level;
  const Denoised mln = value_of(denoise(x, sym5, options));
  const Samples thresholds = g["thresholds_mln_d5_to_d1"];
  near(Samples(mln.threshold.rbegin(), mln.threshold.rend()), thresholds, 5);
  near(mln.samples, g["denoised_mln_first16"], 16);

  options.sigma = DenoiseOptions::Sigma::first;
  options.count = DenoiseOptions::Count::coefficients;
  const auto& matlab = g["matlab_N_is_total_coeffs"];
  const Denoised counted = value_of(denoise(x, sym5, options));
  EXPECT_NEAR(counted.threshold.front(), matlab["threshold"], kGolden);
  near(counted.samples, matlab["denoised_first16"], 16);
}

}  // namespace
}  // namespace abbe
