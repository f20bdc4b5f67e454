#include "abbe/compensate/turn_word.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "abbe/core/units.h"

namespace abbe {
namespace {

constexpr int kDecimals = 4;
constexpr double kDigit = 1e-4 * deg;

TEST(TurnTarget, LinearCountsTurns) {
  EXPECT_DOUBLE_EQ(turn_target(Turning::linear, 370, 10 * deg, 0).position, 370 * deg);
  EXPECT_DOUBLE_EQ(turn_target(Turning::linear, 370, 10 * deg, 5 * deg).position, 375 * deg);
}

TEST(TurnTarget, ShortestGoesTheShorterWay) {
  EXPECT_NEAR(turn_target(Turning::shortest, 10, 350 * deg, 0).position, 370 * deg, 1e-12);
  EXPECT_NEAR(turn_target(Turning::shortest, 350, 10 * deg, 0).position, -10 * deg, 1e-12);
  EXPECT_FALSE(turn_target(Turning::shortest, 179.9, 0, 0).ambiguous);
  EXPECT_TRUE(turn_target(Turning::shortest, 180, 0, 0).ambiguous);
  EXPECT_TRUE(turn_target(Turning::shortest, 0, 179.995 * deg, 0).ambiguous);
}

TEST(TurnTarget, SignIsTheDirection) {
  EXPECT_NEAR(turn_target(Turning::sign, 10, 350 * deg, 0).position, 370 * deg, 1e-12);
  EXPECT_NEAR(turn_target(Turning::sign, -10, 350 * deg, 0).position, 10 * deg, 1e-12);
  EXPECT_NEAR(turn_target(Turning::sign, 0.0, 30 * deg, 0).position, 360 * deg, 1e-12);
  EXPECT_NEAR(turn_target(Turning::sign, -0.0, 30 * deg, 0).position, 0, 1e-12);
}

TEST(TurnWord, AnUncorrectedWordStays) {
  for (const Turning turning : {Turning::linear, Turning::shortest, Turning::sign}) {
    const TurnTarget target = turn_target(turning, 90.5, 10 * deg, 0);
    const TurnWord word =
        turn_word(turning, 90.5, target.position, 10 * deg, target.position + 0.4 * kDigit, 0, kDecimals);
    EXPECT_EQ(word.number, 90.5);
    EXPECT_NEAR(word.position, target.position, 1e-12);
    EXPECT_FALSE(word.clamped);
  }
}

// H7: C0. corrected by -0.0005 degrees on an axis whose sign is its direction would make almost a full turn.
TEST(TurnWord, ZeroIsNotPassedWhereTheSignIsTheDirection) {
  const double from = 350 * deg, target = turn_target(Turning::sign, 0.0, from, 0).position;
  const TurnWord word = turn_word(Turning::sign, 0.0, target, from, target - 0.0005 * deg, 0, kDecimals);
  EXPECT_GE(word.number, 0.0);
  EXPECT_LT(word.number, 360.0);
  EXPECT_NEAR(word.position, target, kDigit * 10);
  EXPECT_LT(word.position - from, 11 * deg);
}

TEST(TurnWord, ACorrectionThatTurnsBackLeavesTheAxisWhereItStands) {
  // the output already stands a little farther than the original goes
  const double target = 30 * deg, from = 30.0005 * deg;
  const TurnWord word = turn_word(Turning::sign, 30, target, from, 30.0002 * deg, 0, kDecimals);
  EXPECT_TRUE(word.clamped);
  EXPECT_NEAR(word.position, from, 1e-9);
  EXPECT_NEAR(word.number, 30.0005, 1e-9);
}

TEST(TurnWord, ANegativeWordKeepsItsSignAtZero) {
  const double from = 10 * deg, target = turn_target(Turning::sign, -0.0003, from, 0).position;
  const TurnWord word = turn_word(Turning::sign, -0.0003, target, from, target - 0.0004 * deg, 0, kDecimals);
  EXPECT_TRUE(std::signbit(word.number));
  EXPECT_NE(word.number, 0.0);
  EXPECT_NEAR(word.position, target, 10 * kDigit);
}

// 359.9995 -> 0.0003 is the same place for a control that goes the shorter way.
TEST(TurnWord, ShortestMayPassTheWrap) {
  const double from = 350 * deg, target = turn_target(Turning::shortest, 359.9995, from, 0).position;
  const TurnWord word =
      turn_word(Turning::shortest, 359.9995, target, from, target + 0.0008 * deg, 0, kDecimals);
  EXPECT_NEAR(word.number, 0.0003, 1e-9);
  EXPECT_NEAR(word.position, target + 0.0008 * deg, 1e-9);
}

TEST(TurnWord, NoCorrectionTurnsTheOtherWay) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0, 360), correction(-0.01, 0.01);
  for (int i = 0; i < 20000; ++i) {
    const Turning turning = i % 2 == 0 ? Turning::shortest : Turning::sign;
    double written = std::round(place(random) * 1e3) / 1e3;
    if (turning == Turning::sign && i % 4 == 1) written = -written;
    const double original_from = std::round(place(random) * 1e3) / 1e3 * deg;
    const double from = original_from + std::round(correction(random) * 1e4) / 1e4 * deg;
    const TurnTarget target = turn_target(turning, written, original_from, 0);
    if (target.ambiguous) continue;
    const double wanted = target.position + correction(random) * deg;
    const TurnWord word = turn_word(turning, written, target.position, from, wanted, 0, kDecimals);
    // as far round as the original, within the corrections of both ends
    EXPECT_NEAR(word.position - from, target.position - original_from, 0.05 * deg)
        << written << " from " << original_from / deg;
    EXPECT_NEAR(turn_target(turning, word.number, from, 0).position, word.position,
                1e-12);  // TheWordLeadsWhereItSays
  }
}

}  // namespace
}  // namespace abbe
