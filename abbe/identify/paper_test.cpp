#include "abbe/identify/paper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "abbe/core/units.h"

namespace abbe {
namespace {

using nlohmann::json;
using Origin = PaperCoefficient::Origin;

// The unscaled matrix has singular values from 1.5e7 to 3 (radius 100 mm), and what is known is carried on
// with a lever of 100 mm: some 2e-11 is what doubles leave of a coefficient; how wide the vectors are that
// sum moves it.
constexpr double kCoefficient = 5e-11;
constexpr double kShare = 1e-8;

PaperSine sine_of(const json& pair) { return {pair[0], pair[1]}; }

class Golden : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ifstream file(ABBE_SOURCE_DIR "/../shared/golden/seed004_identification.json");
    if (!file) GTEST_SKIP() << "no golden numbers beside the sources";
    golden_ = json::parse(file);
  }

  /// The test of a plane in the sequence; the angles of XY end before the full turn, those of XZ, YZ at 220
  /// deg.
  [[nodiscard]] PaperTest test_of(const char* name) const {
    const json& g = golden_["sequential_identification"];
    PaperTest test;
    test.plane = *read_plane(name);
    test.radius = g["r"];
    const std::string lower = {static_cast<char>(name[0] + 32), static_cast<char>(name[1] + 32)};
    const json& sines = g["sin_params"][name];
    const int n = g["n"];
    for (int i = 0; i < n; ++i) {
      const double angle = std::string(name) == "XY" ? 2 * std::numbers::pi * i / n : 220 * deg * i / (n - 1);
      test.angle.push_back(angle);
      test.time.push_back(angle / g["omega"].get<double>());
      test.displacement[0].push_back(test.radius * (std::cos(angle) - 1));
      test.displacement[1].push_back(test.radius * std::sin(angle));
    }
    for (std::size_t k = 0; k < 2; ++k) {
      test.velocity[k] = sine_of(sines[std::string("v") + lower[k]]);
      test.acceleration[k] = sine_of(sines[std::string("a") + lower[k]]);
    }
    test.deviation = {g["data"][name]["first"].get<std::vector<double>>(),
                      g["data"][name]["second"].get<std::vector<double>>()};
    return test;
  }

  json golden_;
};

TEST_F(Golden, EqualsTheFiftyDigitNumbers) {
  const PaperResult result = identify_paper({test_of("XY"), test_of("XZ"), test_of("YZ")});
  ASSERT_TRUE(result.finite);
  const json& g = golden_["sequential_identification"];
  const json& wanted = g["coefficients_identified_36"];
  EXPECT_EQ(wanted.size(), 72U);
  for (const auto& [name, value] : wanted.items()) {
    const PaperCoefficient* c = result.find(name);
    ASSERT_NE(c, nullptr) << name;
    EXPECT_NEAR(c->value, value.get<double>(), kCoefficient) << name;
  }
  ASSERT_EQ(result.steps.size(), 8U);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_EQ(result.steps[k].equation, g["steps"][k]["eq"]);
    EXPECT_EQ(result.steps[k].unknowns, g["steps"][k]["unknowns"].get<int>());
    EXPECT_EQ(result.steps[k].rank, g["steps"][k]["rank"].get<int>());
    if (k < 6) continue;
    EXPECT_NEAR(result.steps[k].rms_residual, g["steps"][k]["rms_residual"].get<double>(), 1e-12);
  }
  const json& share = g["dynamic_share_XY"];
  EXPECT_NEAR(result.shares[0].l1, share["L1"].get<double>(), kShare);
  EXPECT_NEAR(result.shares[0].rms, share["rms"].get<double>(), kShare);
  EXPECT_NEAR(result.shares[0].energy, share["energy"].get<double>(), kShare);
}

TEST_F(Golden, SaysWhatIsMeasuredArtefactAndAssumed) {
  const PaperResult result = identify_paper({test_of("YZ"), test_of("XY"), test_of("XZ")});
  EXPECT_EQ(result.find("b_x1")->origin, Origin::artefact);
  EXPECT_EQ(result.find("f_x1")->origin, Origin::artefact);
  EXPECT_EQ(result.find("b_y0")->origin, Origin::measured);
  EXPECT_EQ(result.find("a_x1")->origin, Origin::measured);
  EXPECT_EQ(result.find("d_x1")->origin, Origin::assumed);
  EXPECT_EQ(result.find("l_z2")->origin, Origin::assumed);
  EXPECT_EQ(result.find("b_x1")->test, 1);
}

TEST_F(Golden, SeparatesSumsByTheRatioOfTheRadius) {
  const PaperResult result = identify_paper({test_of("XY")});
  EXPECT_NEAR(result.find("f_y1")->value / result.find("b_y1")->value, 100, 1e-6);
  EXPECT_NEAR(result.find("l_x2")->value / result.find("h_x2")->value, 100, 1e-6);
  EXPECT_EQ(result.steps.size(), 2U);
  EXPECT_EQ(result.find("d_x1")->origin, Origin::missing);
}

TEST_F(Golden, LeastNormOfOneEquation) {
  for (const char* name : {"minnorm_dyXY_sep", "minnorm_dyXY_steady"}) {
    const json& g = golden_[name];
    PaperTest test;
    test.radius = g["r"];
    test.angle = g["theta"].get<std::vector<double>>();
    for (const double angle : test.angle) {
      test.time.push_back(angle / g["omega"].get<double>());
      test.displacement[0].push_back(test.radius * (std::cos(angle) - 1));
      test.displacement[1].push_back(test.radius * std::sin(angle));
    }
    test.velocity = {sine_of(g["sin_params"]["vx"]), sine_of(g["sin_params"]["vy"])};
    test.acceleration = {sine_of(g["sin_params"]["ax"]), sine_of(g["sin_params"]["ay"])};
    test.deviation[1] = g["dy"].get<std::vector<double>>();
    test.deviation[0].assign(test.angle.size(), 0.0);
    const PaperResult result = identify_paper({test});
    EXPECT_EQ(result.steps[0].rank, g["rank"].get<int>()) << name;
    for (std::size_t i = 0; i < 16; ++i)
      EXPECT_NEAR(result.find(g["columns"][i].get<std::string>())->value, g["B_minnorm"][i].get<double>(),
                  kCoefficient)
          << name << ' ' << g["columns"][i];
  }
}

// Computed with 50-digit arithmetic from the equations of seed 004: one radius cannot split b_x1 + r f_x1.
TEST(Paper, SplitOfACollinearPair) {
  constexpr double kSum = 1.19961995e-3, kRadius = 100;
  EXPECT_NEAR(kSum / (1 + kRadius * kRadius), 1.1995e-7, 1e-11);
  EXPECT_NEAR(kRadius * kSum / (1 + kRadius * kRadius), 1.1995e-5, 1e-9);
}

TEST(Paper, SteadySinesOfATest) {
  BallbarTest test;
  test.radius = 50;
  test.feed = 10;
  BallbarRun run;
  for (int i = 0; i < 360; ++i) {
    run.angle.push_back(0.3 + i * deg);
    run.deviation.push_back(1e-3);
  }
  const PaperTest steady = paper_test(test, run);
  run.time = steady.time;
  for (const double angle : run.angle) run.actual.push_back(50 * radial_direction(test.plane, angle));
  const PaperTest fitted = paper_test(test, run);
  const double w = 10.0 / 50;
  for (std::size_t i = 0; i < 360; i += 37) {
    const double angle = run.angle[i], t = steady.time[i];
    EXPECT_NEAR(std::sin(steady.velocity[0].omega * t + steady.velocity[0].phase), -std::sin(angle), 1e-12);
    EXPECT_NEAR(std::sin(steady.velocity[1].omega * t + steady.velocity[1].phase), std::cos(angle), 1e-12);
    EXPECT_NEAR(std::sin(steady.acceleration[0].omega * t + steady.acceleration[0].phase), -std::cos(angle),
                1e-12);
    EXPECT_NEAR(std::sin(steady.acceleration[1].omega * t + steady.acceleration[1].phase), -std::sin(angle),
                1e-12);
    EXPECT_NEAR(std::sin(fitted.velocity[0].omega * t + fitted.velocity[0].phase), -std::sin(angle), 1e-3);
    EXPECT_NEAR(std::sin(fitted.acceleration[1].omega * t + fitted.acceleration[1].phase), -std::sin(angle),
                0.05);
  }
  EXPECT_NEAR(steady.velocity[0].omega, w, 1e-15);
}

TEST(Paper, SharesOfNothing) {
  EXPECT_EQ(dynamic_share({}, {}).l1, 0);
  EXPECT_EQ(dynamic_share(std::vector{1.0}, std::vector{-1.0}).energy, 0.5);
}

}  // namespace
}  // namespace abbe
