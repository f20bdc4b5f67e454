#include "abbe/ballbar/b5r.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

namespace abbe {
namespace {

// Made from the published names of elements; not a file of the maker.
const std::string kReport = R"(<?xml version="1.0"?>
<BALLBAR><TEST_SPEC NAME="XY 150 mm"/><OPERATOR>N. N.</OPERATOR><DATE_STARTED>2026-03-02</DATE_STARTED>
<MACHINE_TESTED NAME="mill 7"><SERIAL_NUMBER>17</SERIAL_NUMBER></MACHINE_TESTED><PLANE TEST_PLANE="XY"/>
<ANALYSIS><FEATURE NAME="AF_SQUARENESS" DT="UT_SQUARENESS">-20.5</FEATURE>
<FEATURE NAME="AF_BACKLASH_A_POS" DT="UT_LENGTH_UM"> 3.25 </FEATURE><FEATURE NAME="AF_NEW" DT="UT_NEW">1</FEATURE>
</ANALYSIS></BALLBAR>)";

TEST(B5r, FeaturesWithTheirUnits) {
  const auto read = read_b5r("a.b5r", kReport);
  ASSERT_TRUE(read.value);
  EXPECT_EQ(read.value->test, "XY 150 mm");
  EXPECT_EQ(read.value->machine, "mill 7");
  EXPECT_EQ(read.value->serial_number, "17");
  EXPECT_EQ(read.value->plane, (TestPlane{0, 1}));
  ASSERT_EQ(read.value->features.size(), 3U);
  EXPECT_EQ(read.value->features[0].unit, "um/m");
  EXPECT_EQ(read.value->features[0].value, -20.5);
  EXPECT_EQ(read.value->features[1].unit, "um");
  EXPECT_EQ(read.value->features[2].unit, "");
}

TEST(B5r, MistakesAreNamed) {
  const auto message = [](const std::string& text) {
    const auto read = read_b5r("a.b5r", text);
    return read.diagnostics.empty() ? "" : read.diagnostics[0].message;
  };
  EXPECT_THAT(message("angle_deg,deviation_um\n"), ::testing::HasSubstr("not XML"));
  EXPECT_THAT(message("<A/>"), ::testing::HasSubstr("no FEATURE"));
  EXPECT_THAT(message("<FEATURE NAME='AF_X'>nan</FEATURE>"), ::testing::HasSubstr("'AF_X' has no number"));
}

TEST(B5r, AnyBytesGiveAValueOrReasons) {
  std::mt19937 random(21);
  for (int round = 0; round < 3000; ++round) {
    std::string text = kReport;
    for (int k = 0; k < 4; ++k) {
      const std::size_t at = random() % text.size();
      if (random() % 2 == 0)
        text[at] = static_cast<char>(random());
      else
        text.erase(at, random() % 30);
    }
    const auto read = read_b5r("a.b5r", text);
    ASSERT_EQ(read.value.has_value(), !has_errors(read.diagnostics));
  }
}

}  // namespace
}  // namespace abbe
