// Drilling cycles with brackets, as the verifying reader takes them.
#include "abbe/verify/bracket_words.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "abbe/chain/test_plan.h"
#include "abbe/core/test_files.h"
#include "abbe/machine/read_profile.h"
#include "abbe/verify/verify.h"

namespace abbe::verifying {
namespace {

using testing::plan_of;
using testing::TestFile;

constexpr double kExact = 1e-12;

std::optional<HolePlace> places(const std::string& text) {
  HoleWords words;
  std::string fault;
  return take_brackets(text, words, fault) ? place_of(words, fault) : std::nullopt;
}

TEST(BracketWords, ArePlacesAndDistances) {
  const auto place = places("CYCLE82(50, 1.5, 2,-20, ,0.3)");
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->retract, 3.5, kExact);
  EXPECT_NEAR(place->bottom, -20, kExact);
  EXPECT_NEAR(place->clear, 50, kExact);
  const auto below = places("cycle81(10,4,1,,7)");
  ASSERT_TRUE(below);
  EXPECT_NEAR(below->bottom, -3, kExact);
  const auto aside = places("CYCLE86(50,0,2,-20,,0.5,3,-0.3,0.4,0,45)");
  ASSERT_TRUE(aside);
  EXPECT_NEAR(aside->reach, 0.5, kExact);
}

TEST(BracketWords, TheSameHoleMayStandElsewhere) {
  const auto same = [](const std::string& first, const std::string& second) {
    HoleWords a, b;
    std::string fault;
    return take_brackets(first, a, fault) && take_brackets(second, b, fault) && same_hole(a, b);
  };
  const std::string cycle = "CYCLE83(50,0,2,-20,,-5,,2,0.1)";
  EXPECT_TRUE(same(cycle, "CYCLE83(50.0031,0.0031,2,-19.9969,,-5,,2,0.1)"));
  EXPECT_FALSE(same(cycle, "CYCLE83(50,0.0031,2,-19.9969,,-5,,2,0.1)")) << "it retracts to another height";
  EXPECT_FALSE(same(cycle, "CYCLE83(50,0,2,-20.001,,-5,,2,0.1)"));
  EXPECT_FALSE(same(cycle, "CYCLE83(50,0,2.001,-20,,-5,,2,0.1)"));
  EXPECT_FALSE(same(cycle, "CYCLE83(50,0,2,-20,,-5,,2,0.2)"));
  EXPECT_FALSE(same(cycle, "CYCLE83(50,0,2,-20,,-5,,2)"));
  EXPECT_FALSE(same("CYCLE81(50,0,2,-20)", "CYCLE85(50,0,2,-20)"));
}

TEST(BracketWords, WhatIsNotSureIsRefused) {
  for (const char* const text :
       {"CYCLE81()", "CYCLE81(50,0,2)", "CYCLE81(50,0,2,R1)", "CYCLE81(50,0,2,-20,5)", "CYCLE81(1,0,2,-20)",
        "CYCLE81(50,0,-2,-20)", "CYCLE81(50,0,2,3)", "CYCLE90(50,0,2,-20)", "CYCLE81(50,0,2,-20,,1)",
        "CYCLE81(50,0,2,-20,,0,2)", "CYCLE81(50,0,2,-20,,0,0,1)", "CYCLE83(50,0,2,-20,,,,,,,,,1)",
        "CYCLE88(50,0,2,-20,,0,3,0)"})
    EXPECT_FALSE(places(text)) << text;
}

TEST(BracketWords, AnyBytesAreReadOrRefused) {
  std::mt19937 random(7);
  const std::string good = "CYCLE84(50,0,2,-20,,0.5,3,,1.25,0,300,300,0,1,,0,,,\"\",\"\",\"\",0,0,1001002)";
  ASSERT_TRUE(places(good));
  for (int i = 0; i < 5000; ++i) {
    std::string text = good;
    for (int k = 0; k < 3; ++k) text[random() % text.size()] = static_cast<char>(random() % 256);
    const auto place = places(text);
    EXPECT_TRUE(!place || place->bottom < place->retract) << text;
  }
}

/// What verification says of an output of a machine without errors.
std::string judged(const std::string& original, const std::string& output) {
  const auto program = [](const std::string& blocks) {
    return "G17 G90 G94 G710 G54 D0\nG0 X0 Y0 Z50\nF200\n" + blocks + "M30\n";
  };
  const TestFile a(program(original)), b(program(output));
  VerifyJob job;
  job.original_path = a.path();
  job.output_path = b.path();
  job.original_name = job.output_name = "part.mpf";
  job.setup.work_offsets[0] = WorkOffset{};
  job.setup.profile = embedded_profile("siemens");
  const Plan plan = plan_of("format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[tool]\nlength = 100\n");
  std::string codes;
  for (const Diagnostic& d : verify_program(plan, job).diagnostics) codes += d.code + " ";
  return codes;
}

TEST(BracketWords, AnOutputThatDrillsElsewhereIsFound) {
  const std::string good = "MCALL CYCLE81(50,0,2,-20)\nX10 Y5\nX20\nMCALL\nG0 X0\nCYCLE82(50,0,2,-20,,1)\n";
  EXPECT_EQ(judged(good, good), "");
  const auto wrong = [&](const std::string& from, const std::string& to) {
    std::string output = good;
    output.replace(output.find(from), from.size(), to);
    return judged(good, output);
  };
  EXPECT_EQ(wrong("X20\n", "MCALL CYCLE81(50,0,2,-20)\nX20\n"), "") << "the same cycle again";
  EXPECT_NE(wrong("(50,0,2,-20)", "(50.01,0.01,2,-19.99)"), "");
  EXPECT_NE(wrong("(50,0,2,-20)", "(50,0,2,-20.01)"), "");
  EXPECT_NE(wrong("X20\n", "X20.01\n"), "");
  EXPECT_NE(wrong("X20\nMCALL", "MCALL\nX20"), "") << "a hole less";
  EXPECT_NE(wrong("MCALL\nG0 X0", "G0 X0\nMCALL"), "") << "a hole more";
  EXPECT_NE(wrong("CYCLE82(50,0,2,-20,,1)", "CYCLE82(50,0,2,-20,,2)"), "");
  EXPECT_NE(wrong("CYCLE82(50,0,2,-20,,1)\n", ""), "");
}

TEST(BracketWords, TheReaderRefusesWhatItCannotFollow) {
  for (const char* const blocks :
       {"MCALL CYCLE81(50,0,2,-20)\nG1 X10\n", "MCALL CYCLE81(50,0,2,-20)\nG0 Z30\n",
        "MCALL CYCLE81(50,0,2,-20)\nSUPA G0 X10\n", "MCALL CYCLE81(50,0,2,-20)\nG2 X10 Y0 I5 J0\n",
        "MCALL CYCLE81(50,0,2,-20)\nCYCLE81(50,0,2,-20)\n", "MCALL CYCLE81(50,0,2,-20)\nMCALL X10\n",
        "MCALL CYCLE81(50,0,2,-20)\nG700\n", "CYCLE81(50,0,2,-20) X10\n", "G18\nCYCLE81(50,0,2,-20)\n",
        "G93\nCYCLE81(50,0,2,-20)\n"})
    EXPECT_NE(judged(blocks, blocks), "") << blocks;
}

}  // namespace
}  // namespace abbe::verifying
