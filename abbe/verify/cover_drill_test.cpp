// Drilling cycles that the output has as lines and rapids: good ones pass, every change is found.
#include <gtest/gtest.h>

#include "abbe/verify/test_programs.h"

namespace abbe::verifying {
namespace {

/// tip = (x + 2e-4 z, y + 1e-5 z^2, z): holes lean and bend.
std::string leaning_machine() {
  std::string text = kMachine;
  text.erase(text.find("[errors]\n"));
  return text + "[errors]\nEXZ = { poly = [0, 0.2] }\nEYZ = { poly = [0, 0, 0.01] }\n";
}

std::string number(double value) {
  std::string text;
  append_fixed(text, value, 4);
  return text;
}

std::string at(double x, double y, double z) {
  return " X" + number(x - 2e-4 * z) + " Y" + number(y - 1e-5 * z * z) + " Z" + number(z);
}

const std::string kOriginal =
    "G0 X0 Y0 Z10\nG98 G82 X5 Y5 Z-30 R2 P0.5 F100 M8\nG81 X9 Z-29 R3\nG80\nG0 X0 Y0 Z10\nM2\n";

std::string good() {
  return "G0" + at(0, 0, 10) + "\nG98 G0" + at(5, 5, 10) + " F100 M8\nG0" + at(5, 5, 2) + "\nG1" +
         at(5, 5, -14) + "\nG1" + at(5, 5, -30) + "\nG4 P0.5\nG0" + at(5, 5, -14) + "\nG0" + at(5, 5, 2) +
         "\nG0" + at(5, 5, 10) + "\nG0" + at(9, 5, 10) + "\nG0" + at(9, 5, 3) + "\nG1" + at(9, 5, -13) +
         "\nG1" + at(9, 5, -29) + "\nG4 P0\nG0" + at(9, 5, -13) + "\nG0" + at(9, 5, 3) + "\nG0" +
         at(9, 5, 10) + "\nG80\nG0" + at(0, 0, 10) + "\nM2\n";
}

VerifyReport judged(const std::string& output) {
  return verify(plan_of(leaning_machine()), kOriginal, output, ideal_job());
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  if (place == std::string::npos) return "not there: " + from;
  return text.replace(place, from.size(), to);
}

TEST(CoverDrill, TheMotionsOfTheCycleAreAccepted) {
  const VerifyReport report = judged(good());
  EXPECT_TRUE(report.agrees) << texts(report) << good();
  EXPECT_LT(report.after.max, 1 * um);
  EXPECT_GT(report.before.max, 9 * um);
  EXPECT_EQ(report.feed_motions, 2U);
}

TEST(CoverDrill, AnExactStopMayStandInPlaceOfNoDwell) {
  const std::string output =
      changed(changed(good(), "G1" + at(9, 5, -29), "G9 G1" + at(9, 5, -29)), "G4 P0\n", "");
  VerifyJob job = ideal_job();
  auto profile = std::make_shared<Profile>(*profile_of(job.setup));
  profile->g[90].meaning = Meaning::exact_stop_once;
  job.setup.profile = profile;
  const VerifyReport report = verify(plan_of(leaning_machine()), kOriginal, output, job);
  EXPECT_TRUE(report.agrees) << texts(report);
  const VerifyReport none = verify(plan_of(leaning_machine()), kOriginal, changed(output, "G9 ", ""), job);
  EXPECT_FALSE(none.agrees);
}

struct Change {
  const char* name;
  std::string from, to;
};

TEST(CoverDrill, WhatTheCycleDoesNotDoIsFound) {
  const std::vector<Change> changes = {
      {"rapid into the hole", "G1" + at(5, 5, -14), "G0" + at(5, 5, -14)},
      {"rapid at the bottom", "G1" + at(5, 5, -30), "G0" + at(5, 5, -30)},
      {"feed out of the hole", "G0" + at(5, 5, -14), "G1" + at(5, 5, -14)},
      {"feed to the initial level", "G0" + at(5, 5, 10) + "\n", "G1" + at(5, 5, 10) + "\n"},
      {"straight through a bent hole", "G1" + at(5, 5, -14) + "\n", ""},
      {"straight out of a bent hole", "\nG0" + at(5, 5, -14), ""},
      {"not at R before the feed", "G0" + at(5, 5, 2) + "\nG1", "G1"},
      {"uncorrected bottom", at(5, 5, -30), " X5 Y5 Z-30"},
      {"too deep", at(5, 5, -30), at(5, 5, -30.02)},
      {"not deep enough", at(5, 5, -30), at(5, 5, -29.98)},
      {"no dwell", "G4 P0.5\n", ""},
      {"another dwell", "G4 P0.5", "G4 P0.4"},
      {"dwell above the hole", "G1" + at(5, 5, -14) + "\n", "G4 P0.5\nG1" + at(5, 5, -14) + "\n"},
      {"a dwell that the cycle has not", "G4 P0\n", "G4 P0.5\n"},
      {"no stop", "G4 P0\n", ""},
      {"another level", "G0" + at(5, 5, 10) + "\nG0" + at(9, 5, 10), "G0" + at(9, 5, 2)},
      {"deeper on the way out", "P0.5\nG0" + at(5, 5, -14), "P0.5\nG0" + at(5, 5, -31)},
      {"another feed", "F100", "F200"},
      {"a feed between", "G1" + at(5, 5, -30), "G1 F50" + at(5, 5, -30)},
      {"a hole elsewhere", at(9, 5, -13), at(9.1, 5, -13)},
      {"coolant too late", " F100 M8\n", " F100\nM8\n"},
      {"machine coordinates", "G0" + at(5, 5, 2), "G53 G0" + at(5, 5, 2)},
      {"a block that can be deleted", "G1" + at(5, 5, -30), "/G1" + at(5, 5, -30)},
  };
  for (const Change& change : changes) {
    const std::string output = changed(good(), change.from, change.to);
    ASSERT_NE(output.rfind("not there", 0), 0U) << output;
    EXPECT_FALSE(judged(output).agrees) << change.name << "\n" << output;
  }
}

TEST(CoverDrill, EveryLineAndEveryCoordinateCounts) {
  const std::string output = good();
  for (std::size_t begin = 0; begin < output.size();) {
    const std::size_t end = output.find('\n', begin) + 1;
    const std::string line = output.substr(begin, end - begin);
    EXPECT_FALSE(judged(output.substr(0, begin) + output.substr(end)).agrees) << "without " << line;
    EXPECT_FALSE(judged(output.substr(0, end) + line + output.substr(end)).agrees) << "twice " << line;
    begin = end;
  }
  for (std::size_t i = 0; i < output.size(); ++i) {
    if (std::string_view("XYZ").find(output[i]) == std::string_view::npos) continue;
    const Decimal word = read_decimal(std::string_view(output).substr(i + 1));
    if (word.value == -14 || word.value == -13) continue;  // between R and the bottom: along the hole
    std::string other = output.substr(0, i + 1);
    append_fixed(other, word.value + 20 * um, 4);
    other += output.substr(i + 1 + word.length);
    EXPECT_FALSE(judged(other).agrees) << output.substr(i, word.length + 1) << " changed passed";
  }
}

/// What no cycle allows to be written out.
TEST(CoverDrill, OtherCyclesStayCycles) {
  for (const char* cycle : {"G83 Q50", "G85", "G73 Q50", "G89"}) {
    const std::string original = changed(kOriginal, "G82", cycle);
    EXPECT_FALSE(verify(plan_of(leaning_machine()), original, good(), ideal_job()).agrees) << cycle;
  }
}

}  // namespace
}  // namespace abbe::verifying
