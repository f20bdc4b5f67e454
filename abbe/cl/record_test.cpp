#include "abbe/cl/record.h"

#include <gtest/gtest.h>

#include "abbe/cl/number_edit.h"

namespace abbe::cl {
namespace {

Record read(const std::string& text) {
  RecordReader reader;
  std::size_t at = 0;
  std::uint64_t line = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    const auto state = reader.add(std::string_view(text).substr(at, end - at), ++line);
    at = end;
    EXPECT_NE(state, RecordReader::State::error) << reader.error().message;
    EXPECT_EQ(state == RecordReader::State::wants_more, at < text.size());
  }
  return reader.record();
}

std::string error_of(const std::string& text) {
  RecordReader reader;
  if (reader.add(text, 1) == RecordReader::State::error) return reader.error().code;
  return reader.finish() == RecordReader::State::error ? reader.error().code : std::string();
}

TEST(Record, NumbersAndWordsStandBetweenCommas) {
  const Record r = read("  GOTO / 1.5, -2 ,.25,1E-3,1.5D+01,+7.\r\n");
  EXPECT_EQ(r.major, "GOTO");
  ASSERT_EQ(r.items.size(), 6U);
  const double expected[] = {1.5, -2, 0.25, 1e-3, 15, 7};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_TRUE(r.items[i].is_number);
    EXPECT_EQ(r.items[i].value, expected[i]);
  }
  EXPECT_EQ(r.items[0].decimals, 1);
}

TEST(Record, ABlankInsideANumberMakesItNone) {
  EXPECT_FALSE(read("GOTO/1,2,3      00000010\n").items[2].is_number);
  EXPECT_FALSE(read("GOTO/1.5.2,0,0\n").items[0].is_number);
  EXPECT_FALSE(read("GOTO/1.5E,0,0\n").items[0].is_number);
}

TEST(Record, ADollarContinuesItAndTwoBeginARemark) {
  const Record r = read("CUTTER/ 10.0, 2.0,$ and this is nothing\n   3.0 $$ a remark, 4\n");
  ASSERT_EQ(r.items.size(), 3U);
  EXPECT_EQ(r.items[2].value, 3);
  EXPECT_EQ(r.line_count, 2U);
  EXPECT_EQ(r.bytes, "CUTTER/ 10.0, 2.0,$ and this is nothing\n   3.0 $$ a remark, 4\n");
  EXPECT_TRUE(read("$$*CATIA0\n").is_remark());
  EXPECT_EQ(read("$$*CATIA0\n").text, "*CATIA0");
  EXPECT_TRUE(read("   \n").is_remark());
}

TEST(Record, TextStaysText) {
  const Record r = read("PPRINT GOTO/1,2,3 $$ all of it\n");
  EXPECT_EQ(r.major, "PPRINT");
  EXPECT_TRUE(r.items.empty());
  EXPECT_EQ(error_of("PPRINT costs 5$\n"), "E-CONTINUE");
  EXPECT_EQ(read("TOOL PATH/A,TOOL,B\n").major, "TOOL PATH");
  EXPECT_EQ(read("END-OF-PATH\n").major, "END-OF-PATH");
}

TEST(Record, WhatIsNoRecordIsSaid) {
  EXPECT_FALSE(read("P1 = POINT/1,2,3\n").is_plain);
  EXPECT_EQ(read("(GOTO/1,2,3)\n").major, "?");
  EXPECT_EQ(error_of("GOTO/1,2,$\n"), "E-CONTINUE");
  EXPECT_EQ(error_of(std::string("GOTO/1,2,3\0\n", 12)), "E-CHAR");
  EXPECT_EQ(error_of("GOTO/" + std::string(70000, '1') + "\n"), "E-LINELEN");
}

TEST(NumberEdit, UnchangedNumbersKeepTheirBytes) {
  const Record r = read("GOTO / 1.500,  25., .005 $$ x\r\n");
  NumberEdit edit(r);
  EXPECT_EQ(edit.set(0, 1.5000049, 5), 1.5);
  EXPECT_FALSE(edit.changed());
  EXPECT_EQ(edit.bytes(), r.bytes);
  EXPECT_EQ(edit.set(0, 1.50012, 5), 1.50012);
  EXPECT_EQ(edit.set(1, 25.1, 5), 25.1);
  EXPECT_EQ(edit.set(2, -0.0000001, 5), 0);
  EXPECT_EQ(edit.bytes(), "GOTO / 1.50012,  25.1, 0. $$ x\r\n");
}

TEST(NumberEdit, TrailingZerosStayWhereTheyAreWritten) {
  const Record r = read("GOTO/1.50,2.5\n");
  NumberEdit edit(r);
  edit.set(0, 1.6, 5);
  edit.set(1, 2.6, 5);
  EXPECT_EQ(edit.bytes(), "GOTO/1.60000,2.6\n");
}

TEST(NumberEdit, ColumnSeventyTwoIsKept) {
  const Record r = read("GOTO/-100.1000,-100.2000,-100.3000,-0.1000000,-0.2000000,-0.9700000\n");
  NumberEdit edit(r);
  for (std::size_t i = 0; i < 3; ++i) edit.set(i, r.items[i].value + 0.00123, 5);
  for (std::size_t i = 3; i < 6; ++i) edit.set(i, r.items[i].value + 0.00000123, 8);
  const std::string text = edit.bytes();
  EXPECT_EQ(text, "GOTO/-100.09877,-100.19877,-100.29877,-0.09999877,-0.19999877,$\n      -0.96999877\n");
  const Record again = read(text);
  ASSERT_EQ(again.items.size(), 6U);
  EXPECT_EQ(again.items[5].value, -0.96999877);
}

}  // namespace
}  // namespace abbe::cl
