// Q words of drilling cycles, and where a hole is.
#include "abbe/program/hole_cycle.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <utility>
#include <vector>

namespace abbe {
namespace {

HoleDefinition definition(int cycle, const std::vector<std::pair<int, double>>& words) {
  HoleDefinition made;
  made.cycle = cycle;
  for (const auto& [parameter, value] : words) made.words.push_back({parameter, value, 0, ""});
  return made;
}

std::string read(int cycle, const std::string& line) {
  Block block;
  bool comma = false;
  if (begin_block(line, block)) return "line";
  if (const auto error = read_hole_words(cycle, 0, line.size(), comma, block)) return error->code;
  std::string text;
  for (int i = 0; i < block.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    text += std::to_string(block.parameters[k]) + ":" +
            line.substr(block.words[k].number,
                        static_cast<std::size_t>(block.words[k].end - block.words[k].number)) +
            (comma ? "," : " ");
  }
  return text;
}

TEST(HoleCycle, WordsStandWhereTheyAre) {
  EXPECT_EQ(read(200, "Q200=2"), "200:2 ");
  EXPECT_EQ(read(200, " Q200 = +2.5  Q201=-10 "), "200:+2.5 201:-10 ");
  EXPECT_EQ(read(203, "Q203=+0,5"), "203:+0,5,");
  EXPECT_EQ(read(200, "Q206=FAUTO Q210=0"), "206:FAUTO 210:0 ");
  EXPECT_EQ(read(201, ""), "");
}

TEST(HoleCycle, WhatIsNotLiteralOrNotItsOwnIsRefused) {
  const std::vector<std::pair<const char*, const char*>> refused = {
      {"Q200=Q5", "E-EXPR"},       {"Q200", "E-EXPR"},           {"Q200=", "E-EXPR"},
      {"Q206=-5", "E-EXPR"},       {"Q201=MAX", "E-EXPR"},       {"Q239=1", "E-CYCLE"},
      {"X+5", "E-CYCLE"},          {"Q200=1 Q200=2", "E-CYCLE"}, {"Q200=1;Q5", "E-EXPR"},
      {"Q200000000=1", "E-CYCLE"}, {"Q201=1e5", "E-EXPR"},       {"Q=5", "E-CYCLE"}};
  for (const auto& [line, code] : refused) EXPECT_EQ(read(200, line), code) << line;
}

std::string read_line(int cycle, int part, const std::string& line) {
  Block block;
  bool comma = false;
  if (begin_block(line, block)) return "line";
  if (const auto error = read_hole_value(cycle, part, 0, line.size(), comma, block)) return error->code;
  const Word& word = block.words[0];
  return std::to_string(block.parameters[0]) + ":" +
         line.substr(word.number, static_cast<std::size_t>(word.end - word.number)) + (comma ? "," : "");
}

// Controls in other languages spell the names of the lines otherwise.
TEST(HoleCycle, LinesOfOlderCycles) {
  EXPECT_EQ(read_line(1, 1, " SET UP 2"), "1:2");
  EXPECT_EQ(read_line(1, 2, " TIEFE-20.5"), "2:-20.5");
  EXPECT_EQ(read_line(1, 4, " V.ZEIT 0,5"), "4:0,5,");
  EXPECT_EQ(read_line(1, 5, " F229"), "5:229");
  EXPECT_EQ(read_line(17, 3, "+1.5"), "3:+1.5");
  for (const char* line : {" SET UP Q1", " SET UP", "", " SETUPQ1", " SET UP QL5", " F AUTO", " DEPTH -5 6",
                           " PROF.5", " DEPTH -5 M3", " depth -5", " DEPTH 1e3", " DEPTH --5"})
    EXPECT_EQ(read_line(1, 2, line), "E-EXPR") << line;
  EXPECT_EQ(read_line(1, 6, " X 5"), "E-CYCLE");
  EXPECT_EQ(read_line(2, 5, " F100"), "E-CYCLE");
  EXPECT_EQ(read_line(17, 4, " DWELL 1"), "E-CYCLE");
}

// The tool stands one set-up clearance above the surface, and comes back there.
TEST(HoleCycle, OlderCyclesBeginWhereTheToolStands) {
  const auto span = span_of(definition(1, {{1, 2}, {2, -20}, {3, 5}, {4, 0}, {5, 100}})).span;
  ASSERT_TRUE(span);
  EXPECT_TRUE(span->from_start);
  EXPECT_EQ(span->top, -2);
  EXPECT_EQ(span->bottom, -22);
  EXPECT_EQ(span->clear, 0);
  EXPECT_TRUE(span_of(definition(2, {{1, 0}, {2, -20}, {3, 0.5}, {4, 100}})).span);
  EXPECT_TRUE(span_of(definition(17, {{1, 4}, {2, -20}, {3, -1}})).span);
  using Words = std::vector<std::pair<int, double>>;
  for (const Words& words : {Words{{1, -2}, {2, -20}, {3, 5}, {4, 0}, {5, 100}},
                             {{1, 2}, {2, 20}, {3, 5}, {4, 0}, {5, 100}},
                             {{1, 2}, {2, -20}, {3, -5}, {4, 0}, {5, 100}},
                             {{1, 2}, {2, -20}, {3, 5}, {4, -1}, {5, 100}},
                             {{1, 2}, {2, -20}, {3, 5}, {4, 0}, {5, 0}},
                             {{1, 2}, {2, -20}, {3, 5}, {4, 0}}})
    EXPECT_FALSE(span_of(definition(1, words)).span);
  EXPECT_FALSE(span_of(definition(17, {{1, 4}, {2, -20}, {3, 0}})).span);
  EXPECT_FALSE(span_of(definition(2, {{1, 4}, {2, -20}, {3, 0}, {4, 0}})).span);
}

// The heights: clearances and depth count from the surface.
TEST(HoleCycle, HeightsCountFromTheSurface) {
  const auto span = span_of(definition(200, {{200, 2}, {201, -20}, {203, 5}, {204, 50}})).span;
  ASSERT_TRUE(span);
  EXPECT_EQ(span->top, 7);
  EXPECT_EQ(span->bottom, -15);
  EXPECT_EQ(span->clear, 55);
  EXPECT_EQ(span->aside, 0);
  EXPECT_EQ(span_of(definition(207, {{200, 2}, {201, -20}, {203, 5}, {204, 0}})).span->clear, 7);
}

TEST(HoleCycle, BoresReachAside) {
  EXPECT_EQ(span_of(definition(208, {{200, 2}, {201, -9}, {203, 0}, {204, 0}, {335, 30}})).span->aside, 15);
  const auto behind =
      span_of(definition(
                  204, {{200, 2}, {249, 5}, {250, 20}, {251, 3.5}, {252, 15}, {203, 1}, {204, 50}, {214, 1}}))
          .span;
  ASSERT_TRUE(behind);
  EXPECT_EQ(behind->bottom, 1 - 20 - 2 - 15);
  EXPECT_EQ(behind->aside, 3.5);
}

TEST(HoleCycle, WhatLeavesTheMotionToTheControlHasNoSpan) {
  using Words = std::vector<std::pair<int, double>>;
  const std::vector<std::pair<int, Words>> unsure = {
      {200, {{200, 2}, {201, -20}, {203, 0}}},
      {200, {{200, 2}, {201, 20}, {203, 0}, {204, 0}}},
      {200, {{200, 2}, {201, 0}, {203, 0}, {204, 0}}},
      {200, {{200, -2}, {201, -20}, {203, 0}, {204, 0}}},
      {200, {{200, 2}, {201, -20}, {203, 0}, {204, 1}}},
      {200, {{200, 2}, {201, -20}, {203, 0}, {204, 0}, {395, 1}}},
      {208, {{200, 2}, {201, -9}, {203, 0}, {204, 0}, {335, 0}}},
      {204, {{200, 2}, {249, 5}, {250, 0}, {251, 1}, {252, 1}, {203, 0}, {204, 0}, {214, 1}}}};
  for (const auto& [cycle, words] : unsure) {
    const HoleAnswer answer = span_of(definition(cycle, words));
    EXPECT_FALSE(answer.span) << cycle << " " << words.size();
    EXPECT_FALSE(answer.message.empty());
  }
}

TEST(HoleCycle, OnlyDrillingCyclesAreKnown) {
  EXPECT_EQ(hole_cycle_number("CYCL200"), 200);
  EXPECT_EQ(hole_cycle_number("CYCL209"), 209);
  for (const char* other : {"CYCL20", "CYCL2000", "CYCL210", "CYCL20X", "", "CYCL247"})
    EXPECT_EQ(hole_cycle_number(other), 0) << other;
}

TEST(HoleCycle, AnyBytesAreReadOrRefused) {
  std::mt19937 random(5);
  const std::string good = "Q200=+2 Q201=-10,5 Q206=FAUTO Q203 = 0";
  for (int i = 0; i < 20000; ++i) {
    std::string line = good;
    for (unsigned k = 0; k < 1 + random() % 5 && !line.empty(); ++k) {
      const std::size_t at = random() % line.size();
      if (random() % 3 == 0)
        line[at] = static_cast<char>(random() % 256);
      else if (random() % 2 == 0)
        line.erase(at, 1);
      else
        line.insert(at, 1, "Q=0123 ,.-+FM;~"[random() % 15]);
    }
    Block block;
    bool comma = false;
    if (begin_block(line, block)) continue;
    if (read_hole_words(200 + static_cast<int>(random() % 10), 0, block.text.size(), comma, block)) continue;
    for (int k = 0; k < block.count; ++k)
      ASSERT_LE(block.words[static_cast<std::size_t>(k)].end, block.text.size()) << line;
  }
}

}  // namespace
}  // namespace abbe
