// Conversational programs, as the verifying reader sees them: whatever changes is found.
#include "abbe/verify/klartext_words.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "abbe/machine/read_profile.h"
#include "abbe/verify/test_programs.h"

namespace abbe::verifying {
namespace {

const char* const kProgram =
    "0 BEGIN PGM TEST MM\n"
    "1 ; start\n"
    "2 BLK FORM 0.1 Z X+0 Y+0 Z-10\n"
    "3 TOOL CALL \"MILL 10\" Z S1000\n"
    "4 CYCL DEF 7.0 DATUM SHIFT\n"
    "5 CYCL DEF 7.1 X+5\n"
    "6 L X+10 Y+20 R0 FMAX M3\n"
    "7 L Z+50 FMAX\n"
    "8 L IZ-40 F500 M8\n"
    "9 CC X+20 Y+20\n"
    "10 C X+20 Y+10 DR+\n"
    "11 C DR-\n"
    "12 CR X+40 Y+15 R+30 DR-\n"
    "13 CYCL DEF 32.1 T0.01\n"
    "14 L X+60,5 F AUTO M9\n"
    "15 L Z+80 FMAX\n"
    "CYCL DEF 200 DRILLING ~\n"
    " Q200=+2 ;CLEARANCE ~\n"
    " Q201=-10 ~\n"
    " Q206=FAUTO ~\n"
    " Q203=+1 ~\n"
    " Q204=+20\n"
    "L X+30 Y+5 FMAX M99\n"
    "CYCL DEF 208 BORE Q200=1 Q201=-5 Q203=0 Q204=0 Q335=16\n"
    "L X+50 FMAX\n"
    "CYCL CALL\n"
    "L Y+15 FMAX M89\n"
    "L Y+25 FMAX\n"
    "L Y+35 FMAX M99\n"
    "16 CYCL DEF 7.1 X+0\n"
    "17 CYCL DEF 247 PRESET ~\n"
    "  Q339=+5 ;ROW\n"
    "18 L Z-1 R0 FMAX M91\n"
    "19 LBL 1\n"
    "20 STOP\n"
    "21 M30\n"
    "22 LBL 2\n"
    "23 END PGM TEST MM\n";

VerifyJob heidenhain_job() {
  VerifyJob job = ideal_job();
  job.setup.profile = embedded_profile("heidenhain");
  job.setup.tools[1] = ToolEntry{1, 1, {0, 0, 100}, 100.0, 10, "name=\"MILL 10\""};
  job.setup.tools[2] = ToolEntry{2, 2, {0, 0, 100}, 100.0, 10, "name=\"MILL 11\""};
  job.setup.further_offsets[5] = job.setup.further_offsets[6] = WorkOffset{};
  return job;
}

VerifyReport compared(const std::string& output, const std::string& original = kProgram) {
  return verify(plan_of("format = 1\n[machine]\nname = \"m\"\nchain = \"w b X Y Z t\"\n"), original, output,
                heidenhain_job());
}

std::string changed(const std::string& from, const std::string& to) {
  std::string text = kProgram;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(KlartextWords, TheSameProgramAgrees) {
  const VerifyReport report = compared(kProgram);
  EXPECT_TRUE(report.agrees) << texts(report);
  EXPECT_GT(report.events, 15U);
  EXPECT_EQ(report.feed_motions, 5U + 1 + 4 * 9) << "a bore is looked at along nine strokes";
}

TEST(KlartextWords, OtherWaysOfSayingTheSameAgree) {
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"X+60,5", "X60.500"},
           {"IZ-40", "Z+10"},
           {"9 CC X+20 Y+20\n", "CC X+20 Y+20\n"},
           {"10 C X+20 Y+10 DR+\n", "C X+20 Y+10 DR+\nCC X+20 Y+20\n"},
           {"Q203=+1 ~\n Q204=+20", "Q204=20 Q203 = +1,0"},
           {"CYCL DEF 200 DRILLING ~\n Q200=+2 ;CLEARANCE ~", "CYCL DEF 200\nQ200=2;CLEARANCE"},
           {"CYCL CALL\n", "L M99\n"},
           {"CYCL CALL\n", "L X+50.0005 FMAX\nCYCL CALL\n"},
           {"CYCL CALL\n", "CYCL DEF 208 Q200=1 Q201=-5 Q203=0 Q204=0 Q335=16\nCYCL CALL\n"},
           {"L Y+15 FMAX M89\nL Y+25 FMAX\n", "L Y+15 FMAX M99\nL Y+25 FMAX M99\n"}})
    EXPECT_TRUE(compared(changed(from, to)).agrees) << to << texts(compared(changed(from, to)));
}

TEST(KlartextWords, WhateverChangesIsFound) {
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"; start", "; Start"},
      {"Q206=FAUTO", "Q206=FMAX"},
      {"BLK FORM 0.1 Z X+0", "BLK FORM 0.1 Z X+1"},
      {"\"MILL 10\"", "\"MILL 11\""},
      {"S1000", "S100"},
      {"7.1 X+5", "7.1 X+6"},
      {"7.1 X+5", "7.2 Y+5"},
      {" R0", ""},
      {" M3", ""},
      {" M3", " M4"},
      {"FMAX M3", "F500 M3"},
      {"IZ-40", "Z-40"},
      {"IZ-40", "IZ-41"},
      {"IZ-40", "IZ+40"},
      {"F500", "F5000"},
      {"F500", "FMAX"},
      {" F500", ""},
      {"CC X+20", "CC X+21"},
      {"C X+20 Y+10 DR+", "C X+20 Y+10 DR-"},
      {"C X+20 Y+10 DR+", "L X+20 Y+10"},
      {"11 C DR-", "11 C DR+"},
      {"11 C DR-\n", ""},
      {"R+30", "R-30"},
      {"R+30", "R+31"},
      {"CR X+40 Y+15 R+30 DR-", "CR X+40 Y+15 R+30 DR+"},
      {"T0.01", "T0.1"},
      {"X+60,5", "X+60,6"},
      {" F AUTO", ""},
      {" M9", ""},
      {"Q339=+5", "Q339=+6"},
      {"L Z-1 R0 FMAX M91", "L Z-1 R0 FMAX"},
      {"L Z-1 R0 FMAX M91", "L Z-1 R0 M91"},
      {"L Z-1 R0 FMAX M91", "L Z-2 R0 FMAX M91"},
      {"LBL 1", "LBL 3"},
      {"Q200=+2", "Q200=+3"},
      {"Q201=-10", "Q201=-11"},
      {"Q206=FAUTO", "Q206=FMAX ; FAUTO"},
      {" Q206=FAUTO ~\n", ""},
      {"Q203=+1", "Q203=+1,01"},
      {"Q204=+20", "Q204=+30"},
      {"CYCL DEF 200", "CYCL DEF 203"},
      {";CLEARANCE", ";CLEARNESS"},
      {"L X+30 Y+5 FMAX M99", "L X+30 Y+5 FMAX"},
      {"L X+30 Y+5 FMAX M99", "L X+30.01 Y+5 FMAX M99"},
      {"L X+30 Y+5 FMAX M99", "L X+30 Y+5 F500 M99"},
      {"L X+30 Y+5 FMAX M99", "L X+30 Y+5 Z+70 FMAX M99"},
      {"Q335=16", "Q335=18"},
      {"CYCL CALL\n", ""},
      {"CYCL CALL\n", "CYCL CALL\nCYCL CALL\n"},
      {"CYCL CALL\n", "L X+50.1 FMAX\nCYCL CALL\n"},
      {"CYCL CALL\n", "L X+51 FMAX\nCYCL CALL\n"},
      {" M89", ""},
      {" M89", " M99"},
      {"L Y+25 FMAX\n", ""},
      {"L Y+35 FMAX M99", "L Y+35 FMAX"},
      {"20 STOP\n", ""},
      {"M30", "M2"},
      {"LBL 2", "LBL 4"},
      {"8 L", "7 L"},
      {"PGM TEST MM\n1", "PGM TEST INCH\n1"}};
  for (const auto& [from, to] : changes)
    EXPECT_FALSE(compared(changed(from, to)).agrees) << from << " became " << to;
}

constexpr const char* kTip =
    "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z\n2 L X+0 Y+0 Z+300 B+30 C+10 R0 FMAX\n3 M128\n"
    "4 L X+0 Y+5 Z+200 FMAX\n5 L X+100 F500\n6 L X+110 B+20\n7 M129\n8 L X+0 Y+0 Z+400 FMAX\n"
    "9 CALL LBL 1\n10 TOOL DEF 1 L+100\n11 M126\n12 M140 MB MAX\n13 L X+0 Y+0 Z+300 FMAX\n14 M30\n"
    "15 LBL 1\n16 L X+5 F500\n17 LBL 0\n18 END PGM T MM\n";

/// With rotary axes of the head that turn the shortest way, and M128 that controls the tip.
VerifyReport compared_tips(const std::string& output, const std::string& original = kTip) {
  return verify(
      plan_of("format = 1\n[machine]\nname = \"m\"\nchain = \"w b X Y Z C B t\"\n[control]\n"
              "mode = \"axis\"\ncodes = { M128 = \"tcp\", M129 = \"axis\" }\n"
              "[axis.B]\ndirection = [0, 1, 0]\n[axis.C]\ndirection = [0, 0, 1]\n"
              "[control.axis.B]\nturning = \"shortest\"\n[control.axis.C]\nturning = \"shortest\"\n"),
      original, output, heidenhain_job());
}

TEST(KlartextWords, TipsSubprogramsAndToolsAreFollowed) {
  ASSERT_TRUE(compared_tips(kTip).agrees) << texts(compared_tips(kTip));
  const std::vector<std::pair<std::string, std::string>> changes = {{"3 M128\n", ""},
                                                                    {"3 M128", "3 M129"},
                                                                    {"7 M129\n", ""},
                                                                    {"B+30", "B-30"},
                                                                    {"C+10", "C-10"},
                                                                    {"B+20", "B+20.1"},
                                                                    {"X+110 B+20", "X+110"},
                                                                    {"L X+100 F500", "L X+100.01 F500"},
                                                                    {"9 CALL LBL 1\n", ""},
                                                                    {"CALL LBL 1", "CALL LBL 2"},
                                                                    {"16 L X+5", "16 L X+5.01"},
                                                                    {"16 L X+5 F500\n", ""},
                                                                    {"F500\n17", "F600\n17"},
                                                                    {"TOOL DEF 1 L+100", "TOOL DEF 1 L+101"},
                                                                    {"11 M126\n", ""},
                                                                    {"M126", "M127"},
                                                                    {"12 M140 MB MAX\n", ""},
                                                                    {"MB MAX", "MB+50"}};
  for (const auto& [from, to] : changes) {
    std::string text = kTip;
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    EXPECT_FALSE(compared_tips(text).agrees) << from << " became " << to;
  }
  const std::vector<std::pair<std::string, std::string>> refused = {
      {"9 CALL LBL 1\n", "9 CALL LBL 1\nCALL LBL 1\n"},
      {"CALL LBL 1", "CALL LBL 1 REP 2"},
      {"CALL LBL 1", "CALL LBL 0"},
      {"14 M30\n", ""},
      {"17 LBL 0\n", ""},
      {"17 LBL 0", "17 M30"},
      {"M126", "M127"},
      {"TOOL DEF 1 L+100", "TOOL DEF 7 L+100"},
      {"TOOL DEF 1 L+100", "TOOL DEF 1 L+100 X+3"},
      {"TOOL DEF 1 L+100", "TOOL DEF 1 L+100 R+7"},
      {"M140 MB MAX", "M140"},
      {"M140 MB MAX", "L X+5 FMAX M140 MB MAX"},
      {"12 M140", "12 FUNCTION TCPM F CONT\nM140"}};
  for (const auto& [from, to] : refused) {
    std::string text = kTip;
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    EXPECT_FALSE(compared_tips(text, text).agrees) << from << " became " << to;
  }
}

TEST(KlartextWords, NumbersOfBlocksMayGrow) {
  EXPECT_TRUE(compared(changed("23 END", "77 END")).agrees);
  EXPECT_TRUE(compared(changed("22 LBL 2", "22  LBL 2")).agrees);
}

TEST(KlartextWords, WhatIsNotUnderstoodIsRefused) {
  const std::string understood = changed("14 L X", "L X+10 R0\n14 L X");
  EXPECT_TRUE(compared(understood, understood).agrees) << "or the lines below are refused for another reason";
  for (const char* line : {"L X+Q1",
                           "L X+10 R+",
                           "L X+10 RLX",
                           "CYCL DEF 200 Q335=5",
                           "CYCL DEF 200.1 X+5",
                           "CYCL DEF 251 ~",
                           "CYCL DEF 1.1 SET UP 2",
                           "CYCL DEF 1 PECKING",
                           "CYCL DEF 1.0 P\nCYCL DEF 1.1 SET UP Q2",
                           "CYCL DEF 1.0 P\nCYCL DEF 1.1 SETUPQ2",
                           "CYCL DEF 1.0 P\nCYCL DEF 1.6 X2",
                           "CYCL DEF 1.0 P\nCYCL DEF 1.1",
                           "CYCL DEF 1.0 P\nCYCL DEF 1.1 SET UP 2\nCYCL DEF 1.1 SET UP 2",
                           "CYCL DEF 17.0 P\nCYCL DEF 17.1 DIST2\nCYCL DEF 17.2 DEPTH-5\nL X+30 FMAX M99",
                           "CYCL CALL",
                           "CYCL DEF 247 PRESET",
                           "CYCL DEF 200 Q200=1 Q201=-5 Q203=0\nCYCL CALL",
                           "CYCL DEF 200 Q200=1 Q201=5 Q203=0 Q204=0\nCYCL CALL",
                           "CYCL DEF 200 Q200=1 Q201=-5 Q203=Q1 Q204=0",
                           "CYCL DEF 200 Q200=1 Q201=-5 Q203=0 Q204=0\nL X+1 FMAX M9 M99",
                           "CYCL DEF 200 Q200=1 Q201=-5 Q203=0 Q204=0\nL X+1 FMAX M89\nL Z+90 FMAX",
                           "L X+5 F200 FMAX",
                           "L X+60 ~\n Y+5",
                           "CYCL DEF 7.0 SHIFT ~\n CYCL DEF 7.1 X+5",
                           "L X+1 M99",
                           "CALL LBL 1",
                           "PLANE VECTOR STAY",
                           "CP IPA+30 DR+",
                           "CC IX+1 IY+2",
                           "CC X+1",
                           "C X+1 Y+2",
                           "C X+30 Y+20 DR+ FMAX",
                           "CYCL DEF 7.1 #3",
                           "CYCL DEF 7.1 IX+3",
                           "L X+1Y+2",
                           "FN 0: Q1 = 5",
                           "TOOL DEF 3 L+5 R+1",
                           "TOOL DEF 1 L+101",
                           "TOOL CALL 1 Z DL+0.1",
                           "TOOL CALL 1 X",
                           "L IX+1 M91",
                           "L X+1 M128",
                           "CR X+1 Y+2 DR+",
                           "HELLO",
                           "/ L X+1",
                           "L X+1 FU0.1"}) {
    const std::string program = changed("14 L X", std::string(line) + "\n14 L X");
    EXPECT_FALSE(compared(program, program).agrees) << line;
  }
}

// Any bytes: the reader answers, and does not leave the line.
TEST(KlartextWords, AnyBytesAreReadOrRefused) {
  std::mt19937 random(11);
  const std::string text = kProgram;
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1)
    lines.push_back(text.substr(at, text.find('\n', at) - at));
  for (const char* line :
       {"CYCL DEF 1.1 SET UP 2", "CYCL DEF 17.3 PITCH-1", "CYCL DEF 10.1 ROT+30", "CYCL DEF 8.1 X Y",
        "CYCL DEF 26.1 X2 CCX+5", "CYCL DEF 11.1 SCL0.5", "L X+1 RL F5"})
    lines.emplace_back(line);
  Block block;
  Fault fault;
  for (int i = 0; i < 20000; ++i) {
    std::string line = lines[random() % lines.size()];
    for (unsigned k = 0; k < 1 + random() % 4 && !line.empty(); ++k) {
      const std::size_t at = random() % line.size();
      if (random() % 2 == 0)
        line[at] = static_cast<char>(random() % 256);
      else
        line.insert(at, 1, "ICLRFQM;~\"=,+- 9"[random() % 16]);
    }
    const Continued before{random() % 2 == 0, random() % 2 == 0};
    (void)continued_after(line, before);
    if (read_block(line, *embedded_profile("heidenhain"), block, fault, {}, before)) continue;
    ASSERT_STRNE(fault.code, "");
    ASSERT_LE(fault.column, line.size() + 1) << line;
  }
}

}  // namespace
}  // namespace abbe::verifying
