#include "abbe/program/bracket_cycle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

namespace abbe {
namespace {

constexpr double kExact = 1e-12;

TEST(BracketCycle, HeightsAreThoseOfTheNumbers) {
  const BracketAnswer answer = read_bracket_cycle("CYCLE82(50, 1.5, 2,-20, ,0.3)");
  ASSERT_TRUE(answer.cycle) << answer.message;
  EXPECT_EQ(answer.cycle->number, 82);
  EXPECT_NEAR(answer.cycle->span.top, 3.5, kExact);
  EXPECT_NEAR(answer.cycle->span.bottom, -20, kExact);
  EXPECT_NEAR(answer.cycle->span.clear, 50, kExact);
  EXPECT_EQ(answer.cycle->decimals(), 1);
}

TEST(BracketCycle, ADepthBelowTheSurfaceIsNoPlace) {
  const BracketAnswer answer = read_bracket_cycle("cycle81 (10,4,1,,7)");
  ASSERT_TRUE(answer.cycle) << answer.message;
  EXPECT_NEAR(answer.cycle->span.bottom, -3, kExact);
  EXPECT_EQ(answer.cycle->moved(0.0125, 4), "cycle81 (10.0125,4.0125,1,,7)");
}

TEST(BracketCycle, PlacesMoveAndDistancesStay) {
  const BracketAnswer answer =
      read_bracket_cycle("CYCLE83(50,0,2,-20,,-5,,2,0.1,0,1,0,,5,1,0,0,0,0,1001110)");
  ASSERT_TRUE(answer.cycle) << answer.message;
  EXPECT_EQ(answer.cycle->moved(-0.003, 3),
            "CYCLE83(49.997,-0.003,2,-20.003,,-5,,2,0.1,0,1,0,,5,1,0,0,0,0,1001110)");
}

TEST(BracketCycle, AFineBoreStepsAside) {
  const BracketAnswer answer = read_bracket_cycle("CYCLE86(50,0,2,-20,,0.5,3,-0.3,0.4,0,45)");
  ASSERT_TRUE(answer.cycle) << answer.message;
  EXPECT_NEAR(answer.cycle->span.aside, 0.5, kExact);
}

TEST(BracketCycle, WhatIsNotSureIsRefused) {
  for (const char* const text :
       {"CYCLE81", "CYCLE81()", "CYCLE81(50,0,2)", "CYCLE81(50,0,2,R1)", "CYCLE81(50,0,2,-20,5)",
        "CYCLE81(1,0,2,-20)", "CYCLE81(50,0,-2,-20)", "CYCLE81(50,0,2,3)", "CYCLE90(50,0,2,-20)",
        "CYCLE81(50,0,2,-20,,1)", "CYCLE81(50,0,2,-20,,0,2)", "CYCLE81(50,0,2,-20,,0,0,1)",
        "CYCLE83(50,0,2,-20,,,,,,,,,1)", "CYCLE88(50,0,2,-20,,0,3,0)",
        "CYCLE81(50,0,2,-20,,,,,,,,,,,,,,,,,,,,,,,,)"})
    EXPECT_FALSE(read_bracket_cycle(text).cycle) << text;
}

TEST(BracketCycle, AnyBytesAreReadOrRefused) {
  std::mt19937 random(20261123);
  const std::string good = "CYCLE83(50,0,2,-20,,-5,,2,0.1,0,1,0,,5,1,0,0,0,0,10)";
  for (int i = 0; i < 5000; ++i) {
    std::string text = good;
    for (int k = 0; k < 3; ++k) text[random() % text.size()] = static_cast<char>(random() % 256);
    const BracketAnswer answer = read_bracket_cycle(text);
    if (!answer.cycle) continue;
    EXPECT_LT(answer.cycle->span.bottom, answer.cycle->span.top) << text;
    EXPECT_TRUE(read_bracket_cycle(answer.cycle->moved(0.25, 12)).cycle) << text;
  }
}

}  // namespace
}  // namespace abbe
