#include "abbe/errors/error_name.h"

#include <gtest/gtest.h>

namespace abbe {
namespace {

ErrorName name(ErrorClass error_class, int direction, std::string axis) {
  return {error_class, direction, std::move(axis)};
}

TEST(ReadErrorName, ReadsEveryClass) {
  EXPECT_EQ(read_error_name("EXX"), name(ErrorClass::component, 0, "X"));
  EXPECT_EQ(read_error_name("EAZ1"), name(ErrorClass::component, 3, "Z1"));
  EXPECT_EQ(read_error_name("EBC"), name(ErrorClass::component, 4, "C"));
  EXPECT_EQ(read_error_name("EC0Y"), name(ErrorClass::location, 5, "Y"));
  EXPECT_EQ(read_error_name("EX0C"), name(ErrorClass::location, 0, "C"));
  EXPECT_EQ(read_error_name("EA0B1"), name(ErrorClass::location, 3, "B1"));
  EXPECT_EQ(read_error_name("C0Y"), name(ErrorClass::location, 5, "Y"));
  EXPECT_EQ(read_error_name("X0B12"), name(ErrorClass::location, 0, "B12"));
  EXPECT_EQ(read_error_name("TZX"), name(ErrorClass::thermal, 2, "X"));
  EXPECT_EQ(read_error_name("DXX"), name(ErrorClass::dynamic, 0, "X"));
  EXPECT_EQ(read_error_name("EXt"), name(ErrorClass::component, 0, "t"));
  EXPECT_EQ(read_error_name("ECw"), name(ErrorClass::component, 5, "w"));
  EXPECT_EQ(read_error_name("EYS"), name(ErrorClass::component, 1, "S"));
  EXPECT_EQ(read_error_name("EXX0"), name(ErrorClass::component, 0, "X0"));
}

TEST(ReadErrorName, RefusesEverythingElse) {
  for (const char* text :
       {"",     "E",     "EX",   "EXx",  "EQX", "EQ0X", "XX",    "X0",         "X0t", "EX0t", "EX0w",
        "EX0",  "E0X",   "TX0X", "DX0X", "TXt", "DXw",  "TX",    "EXXY",       "EX1", "exx",  "EXX ",
        " EXX", "EXX1a", "FXX",  "EXtt", "T0X", "D0X",  "EX00X", "EX\xc3\x84", "EC0", "C0"}) {
    EXPECT_FALSE(read_error_name(text).has_value()) << text;
  }
}

TEST(ErrorName, IsSpeltInOneWayThatReadsBack) {
  EXPECT_EQ(to_string(*read_error_name("C0Y")), "EC0Y");
  for (const char* prefix : {"E", "T", "D"}) {
    for (const char direction : std::string_view("XYZABC")) {
      for (const char* axis : {"X", "B1", "U12"}) {
        const std::string text = prefix + std::string(1, direction) + axis;
        ASSERT_TRUE(read_error_name(text).has_value()) << text;
        EXPECT_EQ(to_string(*read_error_name(text)), text);
      }
    }
  }
  for (const char* text : {"EX0C", "EXt", "EBw"}) EXPECT_EQ(to_string(*read_error_name(text)), text);
}

TEST(ErrorName, KnowsItsKind) {
  EXPECT_FALSE(read_error_name("EZX")->is_rotation());
  EXPECT_TRUE(read_error_name("EAX")->is_rotation());
  EXPECT_TRUE(read_error_name("C0Y")->is_rotation());
}

}  // namespace
}  // namespace abbe
