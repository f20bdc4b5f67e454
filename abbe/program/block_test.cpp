#include "abbe/program/block.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace abbe {
namespace {

TEST(Block, WordsKnowWhereTheyStand) {
  Block block;
  ASSERT_FALSE(read_block("  n10 G01 x-1.50 (c) Y +.5\r\n", block));
  ASSERT_EQ(block.count, 4);
  EXPECT_EQ(block.eol, "\r\n");
  EXPECT_EQ(block.words[2].letter, 'X');
  EXPECT_EQ(block.words[2].value, -1.5);
  EXPECT_EQ(block.words[2].decimals, 2);
  EXPECT_EQ(block.text.substr(block.words[2].number, 5), "-1.50");
  EXPECT_EQ(block.words[3].value, 0.5);
  EXPECT_EQ(block.words_end, block.text.size());
  EXPECT_TRUE(block.has_comment);
}

TEST(Block, BlanksInsideNumbersDoNotCount) {
  Block block;
  ASSERT_FALSE(read_block("G 0 1 X 1 2 . 5 Y3", block));
  ASSERT_EQ(block.count, 3);
  EXPECT_EQ(block.words[0].value, 1);
  EXPECT_EQ(block.words[1].value, 12.5);
  EXPECT_FALSE(block.words[1].tidy);
  EXPECT_EQ(block.words[2].value, 3);
}

TEST(Block, AnExponentIsAnotherWord) {
  Block block;
  ASSERT_FALSE(read_block("X1E2", block));
  ASSERT_EQ(block.count, 2);
  EXPECT_EQ(block.words[1].letter, 'E');
}

TEST(Block, CommentsAreOpaque) {
  Block block;
  ASSERT_FALSE(read_block("(\xFF#[ G1 X5) ; #100 \x01", block));
  EXPECT_EQ(block.count, 0);
}

struct Bad {
  const char* text;
  const char* code;
  std::size_t column;
};
TEST(Block, SaysWhereItStopsUnderstanding) {
  for (const Bad& bad :
       {Bad{"O100 sub", "E-OWORD", 0}, Bad{"o<part> call [1]", "E-OWORD", 0},
        Bad{"N5 O100 while [#1 LT 2]", "E-OWORD", 3}, Bad{"/ O100 call", "E-OWORD", 2},
        Bad{"X#1", "E-EXPR", 1}, Bad{"X[1]", "E-EXPR", 1}, Bad{"X", "E-NUMBER", 0}, Bad{"XY1", "E-NUMBER", 0},
        Bad{"X-", "E-NUMBER", 0}, Bad{"G1 X1-2", "E-CHAR", 5}, Bad{"G1 \x80", "E-CHAR", 3},
        Bad{"G1 (", "E-COMMENT", 3}, Bad{"G1 (a(b)", "E-COMMENT", 5}, Bad{"G1 /X2", "E-SLASH", 3},
        Bad{"% G1", "E-CHAR", 2}}) {
    Block block;
    const auto error = read_block(bad.text, block);
    ASSERT_TRUE(error) << bad.text;
    EXPECT_STREQ(error->code, bad.code) << bad.text;
    EXPECT_EQ(error->column, bad.column) << bad.text;
  }
}

TEST(Block, LongLinesAreRefused) {
  Block block;
  EXPECT_FALSE(read_block(std::string(254, ' ') + "\n", block));
  EXPECT_TRUE(read_block(std::string(255, ' ') + "\n", block));
}

TEST(Block, AnyBytesGiveABlockOrAnError) {
  std::mt19937_64 rng{11};
  const std::string alphabet = "GXYZIJ019.-+ ();%/#[\x01\x80\t\r";
  for (int k = 0; k < 200000; ++k) {
    std::string text;
    for (std::size_t n = rng() % 40; n > 0; --n) text += alphabet[rng() % alphabet.size()];
    Block block;
    const auto error = read_block(text, block);
    if (error) continue;
    for (int i = 0; i < block.count; ++i) {
      const Word& word = block.words[static_cast<std::size_t>(i)];
      ASSERT_LE(word.end, block.text.size()) << text;
      ASSERT_LT(word.begin, word.end) << text;
    }
  }
}

TEST(Block, AChecksumIsCalledOne) {
  Block block;
  const auto error = read_block("N10 G1 X5*71", block);
  ASSERT_TRUE(error);
  EXPECT_STREQ(error->code, "E-CHAR");
  EXPECT_EQ(error->column, 9U);
  EXPECT_NE(error->message.find("checksum"), std::string::npos);
}

}  // namespace
}  // namespace abbe
