#include "abbe/program/swivel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

namespace abbe {
namespace {

TEST(Swivel, ReadsItsArgumentsByPlace) {
  const auto swivel = read_swivel("CYCLE800( 1 ,\"A,B(1)\",0,27,1,2,3,-90,,30.5,4,5,6,-1,,1)");
  ASSERT_TRUE(swivel);
  EXPECT_EQ(swivel->before, Vec3(1, 2, 3));
  EXPECT_EQ(swivel->behind, Vec3(4, 5, 6));
  EXPECT_EQ(swivel->angles, (std::array<double, 3>{-90, 0, 30.5}));
  EXPECT_EQ(swivel->axes, (std::array<int, 3>{2, 1, 0}));
  EXPECT_EQ(swivel->direction, -1);
  EXPECT_FALSE(swivel->ends);
  EXPECT_EQ(read_swivel("CYCLE800(0,\"T\",0,57,0,0,0,1,2,3,0,0,0,0)")->axes, (std::array<int, 3>{0, 1, 2}));
  EXPECT_EQ(read_swivel("CYCLE800(0,\"T\",0,39,0,0,0,1,2,3,0,0,0,0)")->axes, (std::array<int, 3>{2, 0, 1}));
  EXPECT_TRUE(read_swivel("CYCLE800( )")->ends);
}

TEST(Swivel, OtherFormsAreNotRead) {
  for (const char* code :
       {"CYCLE800", "CYCLE800(1)", "CYCLE800(0,T,0,57,0,0,0,1,2,3,0,0,0,0)",
        "CYCLE800(0,\"T\",0,64,0,0,0,1,2,3,0,0,0,0)", "CYCLE800(0,\"T\",0,21,0,0,0,1,2,3,0,0,0,0)",
        "CYCLE800(0,\"T\",0,57.5,0,0,0,1,2,3,0,0,0,0)", "CYCLE800(0,\"T\",100,57,0,0,0,1,2,3,0,0,0,0)",
        "CYCLE800(9,\"T\",0,57,0,0,0,1,2,3,0,0,0,0)", "CYCLE800(0,\"T\",0,57,0,0,0,1,2,3,0,0,0,2)",
        "CYCLE800(0,\"0\",0,57,0,0,0,1,2,3,0,0,0,0)", "CYCLE800(0,\"T\",0,57,0,0,0,R1,2,3,0,0,0,0)",
        "CYCLE800(0,\"T\",0,57,0,0,0,1,2,3,0,0,0)", "CYCLE800(0,\"T\",0,57,0,0,0,1,2,3,0,0,0,0,0,0,0)",
        "CYCLE800(0,\"T,0,57,0,0,0,1,2,3,0,0,0,0)"})
    EXPECT_FALSE(read_swivel(code)) << code;
}

// Total on any bytes, and what is read is finite.
TEST(Swivel, AnyBytesAreReadOrNot) {
  const std::string good = "CYCLE800(1,\"TABLE\",0,57,10,-20.5,3,30,0,-45,1,2,3,-1,,1)";
  std::mt19937 random(7);
  for (int i = 0; i < 4000; ++i) {
    std::string code = good;
    for (unsigned k = 0; k <= random() % 4; ++k) {
      const std::size_t at = random() % code.size();
      if (random() % 3 == 0)
        code.erase(at, 1 + random() % 5);
      else
        code[at] = static_cast<char>(random() % 256);
      if (code.empty()) code = "(";
    }
    const auto swivel = read_swivel(code);
    if (!swivel) continue;
    EXPECT_TRUE(swivel->before.allFinite() && swivel->behind.allFinite()) << code;
    for (const double angle : swivel->angles) EXPECT_TRUE(std::isfinite(angle)) << code;
  }
}

}  // namespace
}  // namespace abbe
