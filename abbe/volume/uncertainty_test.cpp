#include "abbe/volume/uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>

#include "abbe/volume/test_volume.h"

namespace abbe {
namespace {

using namespace test;

/// Machine and modes of one text: errors, [uncertainty], [[uncertainty_mode]].
struct Case {
  Machine machine;
  UncertaintyModes modes;
  explicit Case(const std::string& errors, const char* chain = "w b X Y Z t") {
    const std::string text =
        std::string("format = 1\n[machine]\nchain = \"") + chain +
        "\"\n[axis.X]\nrange = [0, 500]\n[axis.Y]\nrange = [0, 400]\n[axis.Z]\nrange = [0, "
        "300]\n[tool]\nlength = 100\n[errors]\n" +
        errors;
    machine = read(text).value.value();
    modes = read_uncertainty_modes(machine, {"m.toml", text}, {}).value.value();
  }
  [[nodiscard]] VolumeUncertainty ask(std::size_t count, std::size_t trials = 0, unsigned threads = 0,
                                      std::uint64_t seed = 1) const {
    UncertaintyQuestion question{question_of(machine, count), {}, trials, seed};
    question.volume.circumstances.threads = threads;
    return volume_uncertainty(machine, modes, question);
  }
};

constexpr double kRounding = 1e-12;    // mm
constexpr double kSecondOrder = 1e-7;  // mm: products of these errors

TEST(VolumeUncertainty, ClosedFormOfSquareness) {
  // The slide Y leans by u(EC0Y): x moves by -y u. Scale error of X: u(EXX) everywhere.
  const Case c("EC0Y = 0\nEXX = 3\n[uncertainty]\nEC0Y = 10\nEXX = 1.5\n");
  const VolumeUncertainty found = c.ask(3);
  const VolumeGrid grid = question_of(c.machine, 3).grid;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double y = grid.at(i)[1];
    EXPECT_NEAR(found.u[i][0], std::hypot(y * 10 * urad, 1.5 * um), kRounding);
    EXPECT_NEAR(found.u[i][1], 0, kRounding);
    EXPECT_NEAR(found.u_from_datum[i][0], y * 10 * urad,
                kRounding);  // one number for the whole travel cancels
  }
}

TEST(VolumeUncertainty, CorrelatedErrorsAddOrCancel) {
  // One mode for both: EXX and -EXY move the tip by opposite amounts.
  const Case together("EXX = 1\nEXY = 1\n[[uncertainty_mode]]\nEXX = 2\nEXY = -2\n");
  EXPECT_NEAR(together.ask(2).u[0][0], 0, kRounding);
  const Case apart("EXX = 1\nEXY = 1\n[[uncertainty_mode]]\nEXX = 2\n[[uncertainty_mode]]\nEXY = -2\n");
  EXPECT_NEAR(apart.ask(2).u[0][0], std::sqrt(8.0) * um, kRounding);
}

TEST(VolumeUncertainty, FirstOrderAgreesWithMonteCarlo) {
  const Case c(
      "EXX = { poly = [0, 0.02] }\nEBX = { poly = [0, 0.03] }\nEC0Y = 12\nEAZ = 4\n[uncertainty]\nEAZ = "
      "3\nEC0Y = 4\n[[uncertainty_mode]]\nEXX = { poly = [0, 0.004] }\nEBX = { poly = [1, -0.01] "
      "}\n[[uncertainty_mode]]\nEBX = 2\n",
      "w b X Y Z t");
  constexpr std::size_t kTrials = 2000;
  const VolumeUncertainty found = c.ask(4, kTrials);
  ASSERT_EQ(found.status, VolumeUncertainty::Status::done);
  for (std::size_t i = 0; i < found.u.size(); ++i)
    for (int k = 0; k < 3; ++k)  // u of a standard deviation: 1 / sqrt(2 n), five of them
      EXPECT_NEAR(found.u_drawn[i][k], found.u[i][k],
                  5 * found.u[i][k] / std::sqrt(2.0 * kTrials) + kSecondOrder);
  EXPECT_LT(found.max.low, found.max.value);
  EXPECT_GT(found.max.high, found.max.value);
}

TEST(VolumeUncertainty, IntervalsCoverTheTruth) {
  // One normal number: 95 % of the trials of the largest deviation are those within 1.96 u.
  const Case c("EXX = 100\n[uncertainty]\nEXX = 2\n");
  const VolumeUncertainty found = c.ask(2, 8000);
  EXPECT_NEAR(found.max.low / um, 100 - kCoverage95 * 2, 0.25);
  EXPECT_NEAR(found.max.high / um, 100 + kCoverage95 * 2, 0.25);
  EXPECT_NEAR(found.max.u / um, 2, 0.08);
}

TEST(VolumeUncertainty, SameForAnyNumberOfThreads) {
  const Case c("EXX = 1\nEC0Y = 3\n[uncertainty]\nEXX = 1\nEC0Y = 2\n");
  const VolumeUncertainty one = c.ask(5, 50, 1), three = c.ask(5, 50, 3), other = c.ask(5, 50, 3, 2);
  for (std::size_t i = 0; i < one.u.size(); ++i) EXPECT_EQ(one.u_drawn[i], three.u_drawn[i]);
  EXPECT_EQ(one.max.high, three.max.high);
  EXPECT_NE(one.max.high, other.max.high);
}

TEST(VolumeUncertainty, SensorsOfModesAreThoseOfTheErrors) {
  const Case c(
      "EXX = { poly = [0, 1], of = \"T1\" }\n[[uncertainty_mode]]\nEXX = { poly = [0, 0.1], of = \"T1\" }\n");
  UncertaintyQuestion question{question_of(c.machine, 2), {{"T1", 5}}, 10, 1};
  EXPECT_NEAR(volume_uncertainty(c.machine, c.modes, question).u[0][0], 0.5 * um, kRounding);
  question.environment.clear();
  EXPECT_EQ(volume_uncertainty(c.machine, c.modes, question).status,
            VolumeUncertainty::Status::missing_sensor);
}

TEST(UncertaintyModes, ErrorsWithoutModesHaveTheirOwn) {
  const Case c("EXX = 1\nEYX = 1\nEZX = 1\n[uncertainty]\nEXX = 1\nEYX = 2\n[[uncertainty_mode]]\nEXX = 5\n");
  EXPECT_EQ(c.modes.modes.size(), 2U);  // EXX by its mode, EYX by itself, EZX is certain
  EXPECT_NEAR(c.ask(2).u[0][0], 5 * um, kRounding);
  EXPECT_NEAR(c.ask(2).u[0][1], 2 * um, kRounding);
}

TEST(UncertaintyModes, MistakesAreNamed) {
  const std::string text =
      "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEXX = 1\n[[uncertainty_mode]]\nEYX = 1\n";
  const Machine machine = read(text).value.value();
  const auto modes = read_uncertainty_modes(machine, {"m.toml", text}, {});
  ASSERT_FALSE(modes.value);
  EXPECT_EQ(modes.diagnostics.front().code, "E-UNCERTAINTY");
  EXPECT_FALSE(read_uncertainty_modes(machine, {"m.toml", "[[uncertainty_mode]]\nEQX = 1\n"}, {}).value);
  EXPECT_FALSE(read_uncertainty_modes(machine, {"m.toml", "uncertainty_mode = 3\n"}, {}).value);
  EXPECT_FALSE(read_uncertainty_modes(machine, {"m.toml", "\xff["}, {}).value);
}

}  // namespace
}  // namespace abbe
