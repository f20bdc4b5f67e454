#include "abbe/evaluate/run_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "abbe/evaluate/test_runs.h"

namespace abbe {
namespace {

constexpr const char* kCsv =
    "# a comment\n"
    "target [mm]; run; direction; deviation [um]\n"
    "0; 1; +; 0\n100; 1; +; 1.5\n100; 1; -; 2.5\n0; 1; -; 1\n";

constexpr const char* kRtl =
    "HEADER::\nFile type  : rtl\nOwner      : Linear\n\n"
    "TARGET DATA::\nFiletype  : ISO\nTarget-count: 3\nTargets :\n 0.0000 100.0000\n 200.0000\nFlags: 0 0 2 "
    "0\n\n"
    "USER-TEXT::\nMachine: M\nDate: 2026-03-02 10:00:00\n\nRUNS::\nRun-count:2\n\n"
    "DEVIATIONS::\nRun Target Data:\n 1 1 0.5\n 1 2 1.5\n 1 3 2.5\n 2 3 3.5\n 2 2 4.5\n 2 1 5.5\n\nEOF::\n";

std::string first_code(const Diagnostics& diagnostics) {
  return diagnostics.empty() ? "" : diagnostics.front().code;
}
std::string code_of(const std::string& text) { return first_code(read_runs("x.csv", text).diagnostics); }

TEST(ReadRuns, UnitsAndDirections) {
  const auto runs = read_runs("x.csv", kCsv);
  ASSERT_TRUE(runs.value) << first_code(runs.diagnostics);
  EXPECT_EQ(runs.value->targets, (std::vector<double>{0, 100}));
  EXPECT_NEAR(runs.value->forward(1, 0), 1.5e-3, 1e-18);
  EXPECT_NEAR(runs.value->backward(0, 0), 1e-3, 1e-18);
  EXPECT_NEAR(runs.value->backward(1, 0), 2.5e-3, 1e-18);
}

TEST(ReadRuns, MeasuredPositionsBecomeDeviations) {
  const auto runs =
      read_runs("x.csv", "target [mm],run,direction,measured [mm]\n0,1,+,0.001\n10,1,+,9.998\n");
  ASSERT_TRUE(runs.value);
  EXPECT_NEAR(runs.value->forward(1, 0), -0.002, 1e-12);
  EXPECT_EQ(runs.value->backward.cols(), 0);
}

TEST(ReadRuns, WhatIsWrittenReadsBack) {
  const RunTable table = test::slit_axis();
  const auto back = read_runs("x.csv", write_runs(table));
  ASSERT_TRUE(back.value);
  EXPECT_EQ(back.value->targets, table.targets);
  EXPECT_LT((back.value->forward - table.forward).norm(), 1e-15);
  EXPECT_LT((back.value->backward - table.backward).norm(), 1e-15);
}

TEST(ReadRuns, EveryMistakeHasItsName) {
  const std::string head = "target [mm],run,direction,deviation [um]\n";
  EXPECT_EQ(code_of(""), "E-MEASURED-HEADER");
  EXPECT_EQ(code_of("target [furlong],run\n1,1\n"), "E-MEASURED-HEADER");
  EXPECT_EQ(code_of(head + "0,1,+,nan\n1,1,+,0\n"), "E-MEASURED-CELL");
  EXPECT_EQ(code_of(head + "0,1,+,\n1,1,+,0\n"), "E-MEASURED-CELL");
  EXPECT_EQ(code_of(head + "0,1,up,1\n1,1,+,0\n"), "E-MEASURED-CELL");
  EXPECT_EQ(code_of(head + "0,1,+\n"), "E-MEASURED-CELL");
  EXPECT_EQ(code_of("target,run,direction,deviation [um]\n0,1,+,1\n1,1,+,1\n"), "E-RUN-COLUMN");
  EXPECT_EQ(code_of("target [mm],run,direction,deviation\n0,1,+,1\n1,1,+,1\n"), "E-RUN-COLUMN");
  EXPECT_EQ(code_of("target [mm],run,direction,a [um],b [um]\n0,1,+,1,1\n"), "E-RUN-COLUMN");
  EXPECT_EQ(code_of(head + "0,1,+,1\n100,1,+,1\n0,1,+,1\n"), "E-RUN-TWICE");
  EXPECT_EQ(code_of(head + "0,1,+,1\n100,1,+,1\n0,2,+,1\n"), "E-RUN-MISSING");
  EXPECT_EQ(code_of(head + "0,1,+,1\n"), "E-RUN-FEW");
  EXPECT_EQ(code_of(head + "0,1,+,1\n100,1,+,60000\n"), "E-RUN-LARGE");
  EXPECT_EQ(code_of(head + "0,1,+,1\n100,1,+,1600\n"), "W-RUN-LARGE");
}

TEST(ReadRuns, RunsThatAreAllDifferentNeedNoMemoryForTheRest) {
  // The numbers of rows in the column of runs: a full table would have 4e10 places.
  constexpr int kRows = 200'000;
  std::vector<RunReading> readings;
  for (int i = 0; i < kRows; ++i) readings.push_back({1.0 * i, 0, i + 1, true, 0});
  const auto runs = sort_runs("x.csv", readings, Quantity::length, Quantity::length);
  EXPECT_EQ(first_code(runs.diagnostics), "E-RUN-MISSING");
  EXPECT_LE(runs.diagnostics.size(), 100U);
}

TEST(ReadRuns, OutliersAreNamedNotDropped) {
  std::string text = "target [mm],run,direction,deviation [um]\n";
  for (int run = 1; run <= 5; ++run)
    for (int i = 0; i < 5; ++i)
      text += std::to_string(100 * i) + "," + std::to_string(run) + ",+," +
              std::to_string(i + 0.1 * ((run * 7 + i * 3) % 5) + (run == 3 && i == 2 ? 12 : 0)) + "\n";
  const auto runs = read_runs("x.csv", text);
  ASSERT_TRUE(runs.value);
  ASSERT_EQ(runs.diagnostics.size(), 1U);
  EXPECT_EQ(runs.diagnostics[0].code, "W-RUN-OUTLIER");
  EXPECT_EQ(runs.diagnostics[0].place.line, 14U);
}

TEST(ReadRtl, RunsThatFallAreBackward) {
  const auto runs = read_runs("x.rtl", kRtl);
  ASSERT_TRUE(runs.value) << first_code(runs.diagnostics);
  EXPECT_EQ(first_code(runs.diagnostics), "W-RTL-FORM");
  EXPECT_EQ(runs.value->targets, (std::vector<double>{0, 100, 200}));
  EXPECT_NEAR(runs.value->forward(2, 0) / um, 2.5, 1e-12);
  EXPECT_NEAR(runs.value->backward(0, 0) / um, 5.5, 1e-12);
}

TEST(ReadRtl, DirectionIsThatOfThePositionsNotOfTheirNumbers) {
  // Z is often listed downwards: the first run falls although the numbers of its targets rise.
  std::string text = kRtl;
  text.replace(text.find("Targets :"), 9, "Targets :\n0 -100 -200\nWas :");
  const auto runs = read_runs("z.rtl", text);
  ASSERT_TRUE(runs.value) << first_code(runs.diagnostics);
  EXPECT_EQ(runs.value->targets, (std::vector<double>{-200, -100, 0}));
  EXPECT_NEAR(runs.value->backward(0, 0) / um, 2.5, 1e-12);
  EXPECT_NEAR(runs.value->forward(2, 0) / um, 5.5, 1e-12);
}

TEST(ReadRtl, OtherOwnersNeedAUnit) {
  std::string text = kRtl;
  text.replace(text.find("Linear"), 6, "Angular");
  EXPECT_EQ(first_code(read_runs("x.rtl", text).diagnostics), "E-RTL-UNIT");
  const auto runs = read_runs("x.rtl", text, {}, find_measured_unit("arcsec"));
  ASSERT_TRUE(runs.value);
  EXPECT_EQ(runs.value->quantity, Quantity::angle);
  EXPECT_NEAR(runs.value->forward(2, 0) / arcsec, 2.5, 1e-12);
}

TEST(ReadRtl, RefusesWhatItDoesNotKnow) {
  std::string text = kRtl;
  text.replace(text.find("Target-count: 3"), 15, "Target-count: 4");
  EXPECT_EQ(first_code(read_runs("x.rtl", text).diagnostics), "E-RTL-FORM");
  text = kRtl;
  text.replace(text.find(" 1 2 1.5"), 8, " 1 2 abc");
  EXPECT_EQ(first_code(read_runs("x.rtl", text).diagnostics), "E-RTL-FORM");
  EXPECT_EQ(first_code(read_runs("x.rtl", "HEADER::\nEOF::\n").diagnostics), "E-RTL-FORM");
}

TEST(ReadRuns, TotalOnAnyBytes) {
  std::mt19937 random(20260302);
  const std::string seeds[] = {kCsv, kRtl, write_runs(test::slit_axis())};
  for (int round = 0; round < 4000; ++round) {
    std::string text = seeds[round % 3];
    for (int k = 0; k < 1 + round % 5; ++k) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.erase(at, random() % 20);
          break;
        case 2:
          text.insert(at, text.substr(random() % text.size(), random() % 30));
          break;
        default:
          text.insert(at, "\n-1e308,");
          break;
      }
      if (text.empty()) text = "x";
    }
    const auto runs = read_runs("x", text);
    EXPECT_NE(runs.value.has_value(), has_errors(runs.diagnostics)) << text;
    if (!runs.value) continue;
    EXPECT_TRUE(runs.value->forward.allFinite() && runs.value->backward.allFinite()) << text;
    EXPECT_GE(runs.value->targets.size(), 2U);
  }
}

}  // namespace
}  // namespace abbe
