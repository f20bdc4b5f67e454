// CYCLE81 to CYCLE89 and MCALL: each hole is shifted as a whole, or the block is refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "abbe/compensate/rewrite_fixture.h"
#include "abbe/machine/read_profile.h"

namespace abbe::testing {
namespace {

using ::testing::HasSubstr;

/// X goes 20 um too far per 100 mm, Z rises by 10 um per 100 mm of X, and X leans by `lean` per mm of Z.
Rewritten siemens(const std::string& blocks, double lean = 0) {
  RewriteJob job = plain_job();
  job.setup.profile = embedded_profile("siemens");
  return rewrite(
      three_axes({{"EXX", poly(0, {0, 2e-4})}, {"EZX", poly(0, {0, 1e-4})}, {"EXZ", poly(2, {0, lean})}}),
      "G17 G90 G94 G710 G54 D0\nG0 X0 Y0 Z50\nF200\n" + blocks + "M30\n", job);
}

// At X = 100 the tool stands at 100.020 and 0.010 too high: X 99.980, and all places 0.010 lower. At X = 200
// twice that. To the first order: 2e-4 of 0.02 mm more is below the digits.
TEST(Brackets, EachHoleHasItsOwnHeights) {
  const Rewritten result = siemens("MCALL CYCLE81(50,0,2,-20)\nX100 Y10\nX200\nMCALL\nG0 X0 Y0\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_THAT(result.text,
              HasSubstr("\nMCALL CYCLE81(49.9900,-0.0100,2,-20.0100)\nX99.9800 Y10 Z49.9900\n"
                        "MCALL CYCLE81(49.9800,-0.0200,2,-20.0200)\nX199.9600 Z49.9800\nMCALL\n"));
}

TEST(Brackets, AHoleLikeTheOneBeforeNeedsNoOtherCycle) {
  const Rewritten result = siemens("N5 MCALL CYCLE82(50,0,2,,20,0.5) ; drill\nX100 Y10\nX100.5\nN9 MCALL\n");
  EXPECT_THAT(result.text, HasSubstr("\nN5 MCALL CYCLE82(49.9900,-0.0100,2,,20,0.5) ; drill\nX99.9800 Y10 "
                                     "Z49.9900\nX100.4799\nN9 MCALL\n"))
      << result.findings();
}

TEST(Brackets, ACycleThatIsCalledOnceGetsItsNumbers) {
  const Rewritten result = siemens("G0 X100\nCYCLE83(50,0,2,-20,,-5,,2,0,0,1,1)\nG1 Z45\n");
  EXPECT_THAT(result.text, HasSubstr("\nCYCLE83(49.9900,-0.0100,2,-20.0100,,-5,,2,0,0,1,1)\nG1 Z44.9900\n"))
      << result.findings();
}

// X leans by 5e-5 per mm of height: 2.5 um too far at Z 50, 0.45 um short at mid-depth, Z -9.
//   99.980004 - 0.0025 = 99.9775,  99.980004 + 0.00045 = 99.9805
TEST(Brackets, TheToolGoesToWhereTheHoleNeedsIt) {
  const Rewritten once = siemens("G0 X100\nCYCLE81(50,0,2,-20)\n", 5e-5);
  EXPECT_THAT(once.text, HasSubstr("G0 X99.9775 Z49.9900\nG0 X99.9805\nCYCLE81(")) << once.findings();
  const Rewritten named = siemens("G0 X100\nN9 CYCLE81(50,0,2,-20) ; one\n", 5e-5);
  EXPECT_THAT(named.text, HasSubstr("\nN9 G0 X99.9805 ; one\nCYCLE81(49.9900,")) << named.findings();
  const Rewritten feeding = siemens("G1 X100\nCYCLE81(50,0,2,-20)\n", 5e-5);
  EXPECT_TRUE(feeding.has("E-CYCLE")) << "a G0 of ours would stay in force";
  const Rewritten modal = siemens("MCALL CYCLE81(50,0,2,-10)\nG0 X100\nMCALL\n", 1e-5);
  EXPECT_THAT(modal.text, HasSubstr("G0 X99.9800 Z49.9900\n")) << modal.findings();
}

TEST(Brackets, WhatBendsInTheHoleIsRefused) {
  EXPECT_TRUE(siemens("MCALL CYCLE81(50,0,2,-40)\nX100\nMCALL\n", 1e-3).has("E-CYCLE"));
}

TEST(Brackets, WithoutErrorsNoByteChanges) {
  RewriteJob job = plain_job();
  job.setup.profile = embedded_profile("siemens");
  const std::string program =
      "G17 G90 G94 G710 G54 D0\nG0 X0 Y0 Z50\nF200\nmcall cycle81 (50, 0,2 ,-20)\nX1 Y2\nX2\nMCALL\n"
      "CYCLE86(50,0,2,-20,,0.5,3,-0.3,0.4,0,45)\nM30\n";
  EXPECT_EQ(rewrite(three_axes({}), program, job).text, program);
}

TEST(Brackets, WhatIsNotFollowedIsRefused) {
  struct Case {
    const char *blocks, *code;
  };
  for (const Case& c :
       std::initializer_list<Case>{{"MCALL CYCLE81(50,0,2,-20)\nG1 X10\n", "E-CYCLE"},
                                   {"MCALL CYCLE81(50,0,2,-20)\nG0 Z30\n", "E-CYCLE"},
                                   {"MCALL CYCLE81(50,0,2,-20)\nSUPA G0 X10\n", "E-CYCLE"},
                                   {"MCALL CYCLE81(50,0,2,-20)\nG2 X10 Y0 I5 J0\n", "E-CYCLE"},
                                   {"MCALL CYCLE81(50,0,2,-20)\nG0 X10 M9\n", "E-AUX"},
                                   {"MCALL CYCLE81(50,0,2,-20)\nCYCLE81(50,0,2,-20)\n", "E-CYCLE"},
                                   {"MCALL CYCLE81(50,0,2,-20)\nG700\n", "E-CYCLE"},
                                   {"MCALL CYCLE81(50,0,2,-20)\nMCALL X10\n", "E-CYCLE"},
                                   {"CYCLE81(50,0,2,R5)\n", "E-CYCLE"},
                                   {"CYCLE81(50,0,2,-20) X10\n", "E-BLOCK"},
                                   {"G0 CYCLE81(50,0,2,-20)\n", "E-BLOCK"},
                                   {"CYCLE81(50,0,2,-20) MCALL\n", "E-BLOCK"},
                                   {"/CYCLE81(50,0,2,-20)\n", "E-SKIP"},
                                   {"G18\nCYCLE81(50,0,2,-20)\n", "E-CYCLE"},
                                   {"SCALE X2 Y2 Z2\nG0 X0 Y0 Z50\nCYCLE81(50,0,2,-20)\n", "E-CYCLE"},
                                   {"G93\nCYCLE81(50,0,2,-20)\n", "E-CYCLE"},
                                   {"HOLES1(0,0,0,10,10,5)\n", "E-CYCLE"},
                                   {"SUPA G0 X10 Z0\nCYCLE81(50,0,2,-20)\n", "E-POS"}})
    EXPECT_TRUE(siemens(c.blocks).has(c.code)) << c.blocks << siemens(c.blocks).findings();
}

}  // namespace
}  // namespace abbe::testing
