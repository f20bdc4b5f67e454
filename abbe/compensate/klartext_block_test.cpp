// Lines of conversational programs: what becomes which word, where it stands, what is refused.

#include "abbe/program/klartext_block.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "abbe/machine/read_profile.h"

namespace abbe {
namespace {

const Profile& heidenhain() { return *embedded_profile("heidenhain"); }

/// "X10.5" for every word as the readers take it, or the code of the error.
std::string words_of(const std::string& line, KlartextContext context = {}) {
  Block block;
  if (const auto error = read_klartext_block(line, heidenhain(), context, block)) return error->code;
  std::string text;
  for (int i = 0; i < block.count; ++i) {
    const Word& word = block.words[static_cast<std::size_t>(i)];
    const bool keyword = word.letter == 'G' && word.value >= static_cast<double>(Profile::kGCodes) / 10;
    text += i == 0 ? "" : " ";
    if (word.letter <= 'Z' && word.letter >= 'X' && (block.increments >> (word.letter - 'X') & 1) != 0)
      text += 'I';
    text += keyword ? g_name(heidenhain(), static_cast<std::size_t>(word.value * 10 + 0.5))
                    : fmt::format("{}{:g}", word.letter, word.value);
  }
  return text;
}

TEST(KlartextBlock, MotionsBecomeCodesAndWords) {
  EXPECT_EQ(words_of("12 L X+10.5 IZ-5,25 R0 F500 M3"), "G1 X10.5 IZ-5.25 G40 F500 M3");
  EXPECT_EQ(words_of("12 L X+10.5 RL F500"), "G1 X10.5 G41 F500");
  EXPECT_EQ(words_of("12 L Y+3 F500 RR M8"), "G1 Y3 F500 G42 M8");
  EXPECT_EQ(words_of("L X-0.001 Y 7 FMAX M91"), "G0 X-0.001 Y7 G28");
  EXPECT_EQ(words_of("13 L M8"), "G1 M8");
  EXPECT_EQ(words_of("14 CC X+1 Y-2"), "I1 J-2");
  EXPECT_EQ(words_of("15 C X+5 DR- F AUTO"), "G2 X5 DR AUTO");
  EXPECT_EQ(words_of("16 C DR+"), "G3 DR");
  EXPECT_EQ(words_of("17 CR X+5 IY+3 R-9 DR+ M9"), "G3 X5 IY3 R-9 DR M9");
  EXPECT_EQ(words_of("18 L A+30 C-15 ; turn"), "G1 A30 C-15");
}

TEST(KlartextBlock, OtherBlocksAreUnderstood) {
  EXPECT_EQ(words_of("0 BEGIN PGM 12 MM"), "G21");
  EXPECT_EQ(words_of("0 BEGIN PGM MY PART INCH "), "G20");
  EXPECT_EQ(words_of("9 END PGM 12 MM"), "M2");
  EXPECT_EQ(words_of("3 TOOL CALL 5 Z S900 F100 DL+0"), "T5 M6 G43 S900 F100");
  EXPECT_EQ(words_of("3 TOOL CALL 0 Z"), "T0 M6 G49");
  EXPECT_EQ(words_of("3 TOOL CALL Z S3000"), "S3000");
  EXPECT_EQ(words_of("8 CYCL DEF 7.1 X+5,5"), "CYCL7 X5.5");
  EXPECT_EQ(words_of("8 CYCL DEF 10.0 ROTATION"), "");
  EXPECT_EQ(words_of("8 CYCL DEF 10.1 ROT+35,5"), "CYCL10 R35.5");
  EXPECT_EQ(words_of("8 CYCL DEF 8.1 X Y"), "CYCL8 X0 Y0");
  EXPECT_EQ(words_of("8 CYCL DEF 8.1"), "CYCL8");
  EXPECT_EQ(words_of("8 CYCL DEF 26.1 X1.5 Z2 CCX+10 CCY-5"), "CYCL26 X1.5 Z2 I10 J-5");
  EXPECT_EQ(words_of("8 CYCL DEF 11.1 SCL0.995"), "CYCL11 P0.995");
  EXPECT_EQ(words_of("8 CYCL DEF 32.1 T0.05"), "CYCL32");
  EXPECT_EQ(words_of("8 CYCL DEF 247 PRESET Q339=+4 ;ROW"), "CYCL247 P4");
  EXPECT_EQ(words_of("8 STOP M5"), "M0 M5");
  EXPECT_EQ(words_of("8 CYCL CALL M8"), "M99 M8");
  EXPECT_EQ(words_of("8 TOOL DEF 5 L+10.5 R+3"), "T5 L10.5 R3");
  EXPECT_EQ(words_of("8 CALL LBL \"A B\""), "");
  EXPECT_EQ(words_of("8 PLANE RESET  STAY"), "RESET P0");
  EXPECT_EQ(words_of("8 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS"), "M128");
  EXPECT_EQ(words_of("8 FUNCTION RESET TCPM"), "M129");
  EXPECT_EQ(words_of("8 L M124 T0.01"), "G1 MPOINTS");
  EXPECT_EQ(words_of("8 L M140 MB MAX"), "G1 M140");
  EXPECT_EQ(words_of("8 L X+5 FMAX M99"), "G0 X5 M99");
  EXPECT_EQ(words_of("8 CYCL DEF 200 DRILL ~"), "");
  EXPECT_EQ(words_of("8 CYCL DEF 201 Q QUER Q200=+2 Q201=-5 ;A"), "Q2 Q-5");
  for (const char* line : {"", ";TEXT", "4 * - HEADING", "4 BLK FORM 0.1 Z X-75 Y-140 Z-70", "5 LBL 1",
                           "5 TOOL DEF 7", "6 CYCL DEF 7.0 NULLPUNKT", "7"})
    EXPECT_EQ(words_of(line), "") << line;
}

TEST(KlartextBlock, WhatMayMoveOtherwiseIsRefused) {
  const std::vector<std::pair<std::string, std::string>> refused = {{"L X+Q1", "E-EXPR"},
                                                                    {"L X+10 FQ5", "E-EXPR"},
                                                                    {"Q5 = 3", "E-EXPR"},
                                                                    {"FN 0: Q5 = 3", "E-EXPR"},
                                                                    {"L X+1 R+", "E-GCODE"},
                                                                    {"L X+1 RLX F500", "E-GCODE"},
                                                                    {"CYCL DEF 200 X Q335=5", "E-CYCLE"},
                                                                    {"CYCL DEF 200 Q200=Q1", "E-EXPR"},
                                                                    {"CYCL DEF 251 Q215=0", "E-CYCLE"},
                                                                    {"CYCL DEF 200.1 X+5", "E-GCODE"},
                                                                    {"CYCL DEF 247", "E-WCS"},
                                                                    {"CYCL DEF 247 PRESET ;Q339=1", "E-WCS"},
                                                                    {"L X+1 F500 FMAX", "E-FEED"},
                                                                    {"L X+1 FMAX F AUTO", "E-FEED"},
                                                                    {"CYCL CALL PAT", "E-GCODE"},
                                                                    {"CYCL DEF 7.1 #5", "E-FRAME"},
                                                                    {"CYCL DEF 7.1 IX+5", "E-FRAME"},
                                                                    {"CYCL DEF 10.1 IROT+5", "E-FRAME"},
                                                                    {"CYCL DEF 19.0 PLANE", "E-FRAME"},
                                                                    {"PLANE VECTOR STAY", "E-PLANE"},
                                                                    {"CYCL DEF 4711", "E-CYCLE"},
                                                                    {"CALL LBL 1 REP 2", "E-OWORD"},
                                                                    {"CALL LBL 0", "E-OWORD"},
                                                                    {"LBL", "E-OWORD"},
                                                                    {"M140", "E-MCODE"},
                                                                    {"M140 MB 5 F100", "E-MCODE"},
                                                                    {"CALL PGM A.H", "E-OWORD"},
                                                                    {"FUNCTION TCPM F CONT", "E-TCP"},
                                                                    {"CP IPA+360 IZ-2 DR-", "E-GCODE"},
                                                                    {"RND R5", "E-GCODE"},
                                                                    {"CT X+1 Y+2", "E-GCODE"},
                                                                    {"LN X+1 Y+2 Z+3 NX0 NY0 NZ1", "E-GCODE"},
                                                                    {"C X+1 Y+2", "E-ARC"},
                                                                    {"CR X+1 DR+", "E-ARC"},
                                                                    {"CC", "E-ARC"},
                                                                    {"CC IX+1 IY+1", "E-ARC"},
                                                                    {"CC Y+1 Z+1", "E-ARC"},
                                                                    {"C X+1 DR+ FMAX", "E-FEED"},
                                                                    {"L IX+1 M91", "E-G53"},
                                                                    {"C X+1 DR+ M91", "E-G53"},
                                                                    {"CR X+1 R+5 DR- M91", "E-G53"},
                                                                    {"L IC+5", "E-ROTARY"},
                                                                    {"TOOL CALL 1 Y S5", "E-TOOL"},
                                                                    {"TOOL CALL 1 Z DL+0.1", "E-TOOL"},
                                                                    {"TOOL DEF 1 L+5 X+3", "E-TOOL"},
                                                                    {"TOOL CALL \"A", "E-TOOL"},
                                                                    {"BEGIN PGM A", "E-START"},
                                                                    {"HELLO", "E-GCODE"},
                                                                    {"%", "E-CHAR"},
                                                                    {"L X1E5", "E-EXPR"},
                                                                    {"L X+1Y+2", "E-EXPR"},
                                                                    {"CYCL DEF 247 Q340=+1", "E-WCS"}};
  for (const auto& [line, code] : refused) EXPECT_EQ(words_of("5 " + line), code) << line;
}

TEST(KlartextBlock, ABlockGoesOnBehindATilde) {
  KlartextContext context;
  Block block;
  ASSERT_FALSE(read_klartext_block("7 CYCL DEF 247 PRESET ~", heidenhain(), context, block));
  EXPECT_EQ(block.count, 0);
  ASSERT_FALSE(read_klartext_block("  Q339=+3 ;ROW", heidenhain(), context, block));
  EXPECT_TRUE(block.continues);
  EXPECT_EQ(block.count, 2);
  ASSERT_FALSE(read_klartext_block("; a text~", heidenhain(), context, block));
  ASSERT_FALSE(read_klartext_block(" L X+5 of the text", heidenhain(), context, block));
  EXPECT_EQ(block.count, 0);
  ASSERT_FALSE(read_klartext_block("L X+5", heidenhain(), context, block));
  EXPECT_EQ(block.count, 2);
}

// Drilling cycles have Q words in lines of their own, with '~' or without, until another block comes.
TEST(KlartextBlock, ACycleHasItsWordsInTheLinesBehindIt) {
  KlartextContext context;
  Block block;
  ASSERT_FALSE(read_klartext_block("7 CYCL DEF 208 BORE", heidenhain(), context, block));
  EXPECT_TRUE(block.defines);
  EXPECT_EQ(block.cycle, 208);
  for (const char* line : {"Q200=+2 ;CLEARANCE ~", " Q335=+30 ~", "  ; ~", "Q203=-0,5"}) {
    ASSERT_FALSE(read_klartext_block(line, heidenhain(), context, block)) << line;
    EXPECT_EQ(block.cycle, 208) << line;
    EXPECT_FALSE(block.defines) << line;
  }
  EXPECT_EQ(block.parameters[0], 203);
  EXPECT_EQ(block.words[0].value, -0.5);
  EXPECT_TRUE(context.comma);
  ASSERT_FALSE(read_klartext_block("8 L X+5", heidenhain(), context, block));
  EXPECT_EQ(block.cycle, 0);
  const auto error = read_klartext_block("Q203=5", heidenhain(), context, block);
  ASSERT_TRUE(error);
  EXPECT_STREQ(error->code, "E-EXPR");
}

// What stands in the next line would be lost.
TEST(KlartextBlock, OnlyTextAndPresetsGoOn) {
  for (const char* line : {"~", "5 ~", "5 L X+10 ~", "L X+10 ; text ~", "CC X+1 Y+2 ~", "C X+1 DR+ ~", "L ~",
                           "STOP ~", "TOOL CALL 1 Z ~", "TOOL DEF 1 ~", "CYCL DEF 7.0 SHIFT ~",
                           "CYCL DEF 7.1 X+5 ~", "CYCL DEF 32.1 T0.05 ~", "LBL 1 ~", "0 BEGIN PGM A MM ~"})
    EXPECT_EQ(words_of(line), "E-BLOCK") << line;
  for (const char* line : {"; text ~", "5 ;text~", "* - heading ~", "5 BLK FORM 0.1 Z X+0 ~"})
    EXPECT_EQ(words_of(line), "") << line;
}

// Any bytes: an answer, and words within the line.
TEST(KlartextBlock, AnyBytesAreReadOrRefused) {
  const std::vector<std::string> lines = {"12 L X+10.5 IZ-5,25 R0 F500 M3 ; c",
                                          "CR X+5 IY+3 R-9 DR+ M9",
                                          "3 TOOL CALL \"MILL 8\" Z S900 DL+0",
                                          "8 CYCL DEF 247 P Q339=+4 ~",
                                          "CC X+1 Y-2",
                                          "C X+5 DR- F AUTO",
                                          "CYCL DEF 1.1 SET UP 2",
                                          "CYCL DEF 17.3 PITCH-1",
                                          "CYCL DEF 10.1 ROT+30",
                                          "CYCL DEF 8.1 X Y",
                                          "CYCL DEF 26.1 X2 CCX+5",
                                          "CYCL DEF 11.1 SCL0.5",
                                          "L X+1 RL F5",
                                          "0 BEGIN PGM 12 MM"};
  std::mt19937 random(7);
  Block block;
  KlartextContext context;
  for (int i = 0; i < 20000; ++i) {
    std::string line = lines[random() % lines.size()];
    for (unsigned k = 0; k < 1 + random() % 4; ++k) {
      const std::size_t at = random() % line.size();
      const auto kind = random() % 3;
      if (kind == 0) line[at] = static_cast<char>(random() % 256);
      if (kind == 1) line.erase(at, 1);
      if (kind == 2) line.insert(at, 1, "()[]=\"/:;~_.+-X9"[random() % 16]);
      if (line.empty()) line = " ";
    }
    if (read_klartext_block(line, heidenhain(), context, block)) continue;
    ASSERT_LE(block.words_end, block.text.size()) << line;
    for (int k = 0; k < block.count; ++k) {
      const Word& word = block.words[static_cast<std::size_t>(k)];
      ASSERT_LE(word.begin, word.number) << line;
      ASSERT_LE(word.number, word.end) << line;
      ASSERT_LE(word.end, block.text.size()) << line;
    }
  }
}

}  // namespace
}  // namespace abbe
