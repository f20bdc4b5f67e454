// Subprograms are followed into their lines, in both programs.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "abbe/machine/read_profile.h"
#include "abbe/verify/test_programs.h"

namespace abbe::verifying {
namespace {

const char* const kProgram =
    "%\nO1 (MAIN)\nG21 G90 G17\nG0 X0. Y0. Z5.\nM98 P2\nG0 Z10.\nM30\nO2 (SUB)\nG1 X50. F500\nN5 Y20. "
    "(END)\nM99\n(behind)\n%\n";

VerifyReport compared(const std::string& original, const std::string& output) {
  VerifyJob job = ideal_job();
  job.setup.profile = embedded_profile("fanuc");
  return verify(plan_of("format = 1\n[machine]\nname = \"m\"\nchain = \"w b X Y Z t\"\n"), original, output,
                job);
}

std::string changed(const std::string& from, const std::string& to) {
  std::string text = kProgram;
  return text.replace(text.find(from), from.size(), to);
}

TEST(Subprograms, TheSameProgramAgrees) {
  const VerifyReport report = compared(kProgram, kProgram);
  EXPECT_TRUE(report.agrees) << texts(report);
  EXPECT_EQ(report.feed_motions, 2U);
}

TEST(Subprograms, WhateverChangesInThemIsFound) {
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"X50.", "X50.1"},
      {"Y20.", "Y20.1"},
      {"F500", "F50"},
      {"(END)", "(end)"},
      {"(SUB)", "(sub)"},
      {"N5 ", ""},
      {"M98 P2\n", ""},
      {"M98 P2", "M98 P1"},
      {"O2", "O3"},
      {"M99\n", ""},
      {"(behind)", "(else)"},
      {"M99\n", "M99\nM99\n"},
      {"G1 X50. F500\n", "G1 X50. F500\nX50. Y1.\n"},
      {"Z10.", "Z11."}};
  for (const auto& [from, to] : changes)
    EXPECT_FALSE(compared(kProgram, changed(from, to)).agrees) << from << " -> " << to;
}

TEST(Subprograms, WhatIsNotSureIsRefused) {
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{{"M98 P2", "M98 P2 L2"},
                                                                                 {"M98 P2", "M98 P7"},
                                                                                 {"M98 P2", "M98 P2 X1."},
                                                                                 {"M98 P2", "M99"},
                                                                                 {"N5 Y20.", "M30"},
                                                                                 {"M99\n", ""},
                                                                                 {"O2 (SUB)", "%\nO2 (SUB)"},
                                                                                 {"M98 P2", "M98"},
                                                                                 {"N5 Y20.", "M98 P2"},
                                                                                 {"M99", "M99 X1."}}) {
    const std::string program = changed(from, to);
    const VerifyReport report = compared(program, program);
    ASSERT_FALSE(report.agrees) << from << " -> " << to;
    EXPECT_EQ(report.diagnostics.front().code, "E-OWORD") << texts(report);
  }
}

}  // namespace
}  // namespace abbe::verifying
