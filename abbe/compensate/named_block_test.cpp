// Lines of controls whose words have names: what is a word, where it begins and ends, what is refused.

#include "abbe/program/named_block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "abbe/machine/read_profile.h"

namespace abbe {
namespace {

const Profile& siemens() { return *embedded_profile("siemens"); }

/// "X10.5" for every word, with the text it came from.
std::string words_of(const std::string& line) {
  Block block;
  if (const auto error = read_named_block(line, siemens(), block)) return error->code;
  std::string text;
  for (int i = 0; i < block.count; ++i) {
    const Word& word = block.words[static_cast<std::size_t>(i)];
    text += std::string(i == 0 ? "" : " ") + word.letter + "|" +
            line.substr(word.begin, static_cast<std::size_t>(word.end - word.begin));
  }
  return text;
}

TEST(NamedBlock, WordsAreFoundWithWhatBelongsToThem) {
  EXPECT_EQ(words_of("N10 G1X10.5Y-3 F250"), "N|N10 G|G1 X|X10.5 Y|Y-3 F|F250");
  EXPECT_EQ(words_of("G2 X= 10.5 CR=7;R9"), "G|G2 X|X= 10.5 R|CR=7");
  EXPECT_EQ(words_of("S1=1000 M1=3"), "S|S1=1000 M|M1=3");
  EXPECT_EQ(words_of("MSG(\"a;) \" ) g0 x1"), "G|MSG(\"a;) \" ) G|g0 X|x1");
  EXPECT_EQ(words_of("/3 LIMS = 3000 M3"), "G|LIMS = 3000 M|M3");
  EXPECT_EQ(words_of("FGREF[A]=10"), "G|FGREF[A]=10");
  EXPECT_EQ(words_of("T=\"DRILL 8.5\" M6"), "T|T=\"DRILL 8.5\" M|M6");
  EXPECT_EQ(words_of("N20 START_1: G0 X1"), "N|N20 G|G0 X|X1");
  EXPECT_EQ(words_of("%_N_PART_MPF"), "");
}

TEST(NamedBlock, NumbersStandWhereTheyAreEdited) {
  Block block;
  ASSERT_FALSE(read_named_block("G1 X = -10.50", siemens(), block));
  const Word& x = block.words[1];
  EXPECT_EQ(block.text.substr(x.number, static_cast<std::size_t>(x.end - x.number)), "-10.50");
  EXPECT_EQ(x.value, -10.5);
  EXPECT_EQ(x.decimals, 2);
  ASSERT_FALSE(read_named_block("SUPA Z0", siemens(), block));
  EXPECT_EQ(g_name(siemens(), static_cast<std::size_t>(std::lround(block.words[0].value * 10))), "SUPA");
}

TEST(NamedBlock, AWordMaySayThatItIsADistanceOrAPlace) {
  Block block;
  ASSERT_FALSE(read_named_block("G1 X=IC( -5.5 ) y=ac(3)Z4 F9", siemens(), block));
  EXPECT_EQ(block.increments, 1);  // X
  EXPECT_EQ(block.places, 2);      // Y
  ASSERT_EQ(block.count, 5);
  EXPECT_EQ(block.words[1].value, -5.5);
  EXPECT_EQ(block.text.substr(block.words[1].number, 4), "-5.5");
  EXPECT_EQ(block.words[3].letter, 'Z');
  ASSERT_FALSE(read_named_block("X=IC(5)", siemens(), block));
  EXPECT_EQ(block.words_end, 7) << "words are added behind the bracket";
  ASSERT_FALSE(read_named_block("G2 X=IC(5) I=AC(3) K=ac( -1 )", siemens(), block));
  EXPECT_EQ(block.increments, 1);
  EXPECT_EQ(block.places, 0b101000) << "I and K";
  ASSERT_FALSE(read_named_block("X5", siemens(), block));
  EXPECT_EQ(block.increments | block.places, 0);
}

TEST(NamedBlock, WhatIsNotLiteralIsRefused) {
  for (const char* line : {"X=R1", "X=10+R1", "X10*2", "R1=5", "_HOME=3", "I=IC(5)", "I=AC(5", "X=IC(R1)", "X=IC(5",
                           "R90", "IF R1==5", "DEF REAL A", "GOTOF END", "X==5", "Z=_Z+5"})
    EXPECT_EQ(words_of(line), "E-EXPR") << line;
  for (const char* line : {"UNHEARD_OF", "MSG(\"open", "SUPA(3)", "COMPON=3", "LIMS=S1", "FGROUP(X,Y)"})
    EXPECT_EQ(words_of(line), "E-GCODE") << line;
  EXPECT_EQ(words_of("HOLES1(1,2)"), "E-CYCLE");
  EXPECT_EQ(words_of("CALL \"SUB\""), "E-OWORD");
  EXPECT_EQ(words_of("(comment)"), "E-CHAR");
  EXPECT_EQ(words_of("T=\"DRILL"), "E-TOOL");
  EXPECT_EQ(words_of("A=DC(90)"), "E-EXPR");
}

// Any bytes: an answer, and words within the line.
TEST(NamedBlock, AnyBytesAreReadOrRefused) {
  const std::vector<std::string> lines = {"N10 G1X10.5Y-3 F250 ; c",  "MSG(\"a;) \" ) G0 X=1",
                                          "T=\"DRILL 8.5\" M6 D1",    "/3 FGREF[A]=10 LABEL: SUPA",
                                          "TRANS X1 Y=2 AROT RPL=30", "G1 X=IC(5) Y=AC(-3.25)Z1"};
  std::mt19937 random(7);
  Block block;
  for (int i = 0; i < 20000; ++i) {
    std::string line = lines[random() % lines.size()];
    for (unsigned k = 0; k < 1 + random() % 4; ++k) {
      const std::size_t at = random() % line.size();
      switch (random() % 3) {
        case 0:
          line[at] = static_cast<char>(random() % 256);
          break;
        case 1:
          line.erase(at, 1);
          break;
        default:
          line.insert(at, 1, "()[]=\"/:;%_.+-X9"[random() % 16]);
          break;
      }
      if (line.empty()) line = " ";
    }
    if (read_named_block(line, siemens(), block)) continue;
    std::size_t from = 0;
    for (int k = 0; k < block.count; ++k) {
      const Word& word = block.words[static_cast<std::size_t>(k)];
      ASSERT_GE(word.begin, from) << line;
      ASSERT_LE(word.begin, word.number) << line;
      ASSERT_LE(word.number, word.end) << line;
      ASSERT_LE(word.end, block.text.size()) << line;
      from = word.end;
    }
  }
}

}  // namespace
}  // namespace abbe
