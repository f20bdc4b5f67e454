// What controls differ in: one line of a program, what is written for it, or why it is refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "abbe/compensate/rewrite_fixture.h"
#include "abbe/machine/read_profile.h"

namespace abbe::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// X goes 0.05 um too far per mm; the machine has all three axes.
Machine scaled_machine() { return three_axes({{"EXX", poly(0, {0, 5e-5})}}); }

RewriteJob job_for(const char* dialect) {
  RewriteJob job = plain_job();
  job.setup.profile = embedded_profile(dialect);
  job.setup.tools[1] = ToolEntry{1, 1, {0, 0, 100}, 100.0, 10, ""};
  job.setup.tools[2] = ToolEntry{2, 2, {7, 0, 80}, 80.0, 10, ""};
  job.setup.start = {0.0, 0.0, 0.0};
  return job;
}

/// With what the control leaves open stated.
RewriteJob job_for(const char* dialect, Profile::IntegerWords words,
                   Profile::Units units = Profile::Units::metric) {
  RewriteJob job = job_for(dialect);
  Profile profile = *job.setup.profile;
  profile.numbers.integer_words = words;
  profile.start.units = units;
  job.setup.profile = std::make_shared<const Profile>(std::move(profile));
  return job;
}

std::string body(const std::string& program, const char* dialect) {
  return rewrite(scaled_machine(), program, job_for(dialect)).text;
}

TEST(Dialects, WordsHaveTheDigitsOfTheControl) {
  EXPECT_EQ(body("G21 G90 G0 X100. Y0. Z0.\nM30\n", "fanuc"), "G21 G90 G0 X99.995 Y0. Z0.\nM30\n");
  EXPECT_EQ(body("G21 G90 G0 X100. Y0. Z0.\nM30\n", "grbl"), "G21 G90 G0 X99.9950 Y0. Z0.\nM30\n");
  EXPECT_EQ(body("G20 G90 G0 X4. Y0. Z0.\nM30\n", "fanuc"), "G20 G90 G0 X3.9998 Y0. Z0.\nM30\n");
}

TEST(Dialects, ANumberWithoutAPointIsNotGuessed) {
  const std::string program = "G21 G90 G0 X100 Y0 Z0\nM30\n";
  const auto refused = rewrite(scaled_machine(), program, job_for("fanuc"));
  EXPECT_TRUE(refused.has("E-DECIMAL")) << refused.findings();
  EXPECT_THAT(refused.findings(), HasSubstr("part.ngc:1:12"));
  EXPECT_EQ(rewrite(scaled_machine(), program, job_for("fanuc", Profile::IntegerWords::units)).text,
            "G21 G90 G0 X99.995 Y0 Z0\nM30\n");
  // 100 increments are 0.1 mm: nothing to correct; 100000 are 100 mm
  EXPECT_EQ(rewrite(scaled_machine(), program, job_for("fanuc", Profile::IntegerWords::increments)).text,
            program);
  EXPECT_EQ(rewrite(scaled_machine(), "G21 G90 G0 X100000 Y0 Z0\nM30\n",
                    job_for("fanuc", Profile::IntegerWords::increments))
                .text,
            "G21 G90 G0 X99.995 Y0 Z0\nM30\n");
  EXPECT_EQ(rewrite(scaled_machine(), "G20 G90 G0 X40000 Y0 Z0\nM30\n",
                    job_for("fanuc", Profile::IntegerWords::increments))
                .text,
            "G20 G90 G0 X3.9998 Y0 Z0\nM30\n");
}

TEST(Dialects, CountersAndZerosNeedNoPoint) {
  const auto result = rewrite(
      scaled_machine(), "G21 G90 G0 X0 Y0 Z5.\nG91 G81 X1. Z-2. R-1. K3 F100\nG80\nM30\n", job_for("fanuc"));
  EXPECT_TRUE(result.report.complete) << result.findings();
}

TEST(Dialects, HolesInIncrementsKeepTheirLevels) {
  // Z goes 1 um too far per mm of X: R and Z follow the correction in both modes.
  const Machine leaning = three_axes({{"EZX", poly(0, {0, 1e-4})}});
  const auto result =
      rewrite(leaning, "G21 G90 G0 X0 Y0 Z10.\nG98 G81 X0. Z-5. R2. F100\nG91 X20. K1\nG90 X40.\nG80\nM30\n",
              job_for("fanuc"));
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_THAT(result.text, HasSubstr("G91 X20. K1 R-8.002 Z-7.000\n")) << result.text;
  EXPECT_THAT(result.text, HasSubstr("G90 X40. R1.996 Z-5.004\n")) << result.text;
  // LinuxCNC reads the numbers anew: R2 above the height before
  EXPECT_TRUE(
      rewrite(leaning, "G0 X0 Y0 Z10\nG98 G81 X0 Z-5 R2 F100\nG91 X20 L1\nG80\nM2\n").report.complete);
  EXPECT_TRUE(
      rewrite(leaning, "G0 X0 Y0 Z10\nG98 G81 X0 Z-5 R2 F100\nG91 X20 L1\nG80\nM2\n", job_for("grblhal"))
          .has("E-CYCLE"));
}

TEST(Dialects, WhatTheControlDoesNotResolveIsRefused) {
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G90 G0 X1.2345 Y0 Z0\nM30\n", job_for("fanuc")).has("E-DIGITS"));
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G90 G0 X1.2340 Y0 Z0\nM30\n", job_for("fanuc")).report.complete);
}

TEST(Dialects, WhatRanBeforeDecidesNothing) {
  EXPECT_TRUE(rewrite(scaled_machine(), "G90 G0 X1. Y0 Z0\nM30\n", job_for("fanuc")).has("E-START"));
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G0 X1. Y0 Z0\nM30\n", job_for("fanuc")).has("E-START"));
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G0 G90\nX1. Y0 Z0\nM30\n", job_for("fanuc")).report.complete);
  EXPECT_TRUE(rewrite(scaled_machine(), "G0 X1 Y0 Z0\nM30\n", job_for("grbl")).report.complete);
}

TEST(Dialects, CodesAfterTheMotionStandOnTheLastPiece) {
  const Machine bent = three_axes({{"EYX", poly(0, {0, 0, 1e-6})}});
  const auto fanuc = rewrite(bent, "G21 G90 G0 X0 Y0 Z0\n/2G1 G9 X190. F500 M3 M9\nM30\n", job_for("fanuc"));
  RewriteJob executed = job_for("fanuc");
  executed.setup.block_delete = ControlSetup::BlockDelete::off;
  const auto split = rewrite(bent, "G21 G90 G0 X0 Y0 Z0\n/2G1 G9 X190. F500 M3 M9\nM30\n", executed);
  EXPECT_TRUE(fanuc.has("E-SKIP"));
  ASSERT_TRUE(split.report.complete) << split.findings();
  ASSERT_GT(split.report.blocks.split, 0U);
  const std::size_t first = split.text.find("/2G1"), end = split.text.find('\n', first);
  EXPECT_THAT(split.text.substr(first, end - first), Not(HasSubstr("M9")));
  EXPECT_THAT(split.text.substr(first, end - first), Not(HasSubstr("G9")));
  EXPECT_THAT(split.text.substr(first, end - first), HasSubstr("M3"));
  const std::size_t last = split.text.rfind("/2");
  EXPECT_THAT(split.text.substr(last, split.text.find('\n', last) - last),
              ::testing::AllOf(HasSubstr("M9"), HasSubstr("G9")));
}

TEST(Dialects, LinesStayWithinTheControlsBuffer) {
  const std::string comment(40, 'C');
  const std::string line = "G1 X100. Y0. Z0. F1000 (" + comment + ")";  // 65 bytes
  EXPECT_TRUE(rewrite(scaled_machine(), "G0 X0 Y0 Z0\n" + line + "\nM30\n", job_for("grbl")).report.complete);
  const std::string full =
      "G1 X100 Y0 Z0 F1000 (" + std::string(56, 'C') + ")";  // 78 bytes, two more for the digits
  const auto refused = rewrite(scaled_machine(), "G0 X0 Y0 Z0\n" + full + "\nM30\n", job_for("grbl"));
  EXPECT_TRUE(refused.has("E-LINELEN")) << refused.text;
  EXPECT_TRUE(
      rewrite(scaled_machine(), "G0 X0 Y0 Z0\n" + full + "\nM30\n", job_for("grblhal")).report.complete);
}

TEST(Dialects, FurtherWorkOffsetsAreFollowed) {
  RewriteJob job = job_for("fanuc");
  job.setup.further_offsets[3] = WorkOffset{{100, 0, 0}, 0};
  EXPECT_EQ(rewrite(scaled_machine(), "G21 G90 G54.1 P3 G0 X100. Y0 Z0\nM30\n", job).text,
            "G21 G90 G54.1 P3 G0 X99.990 Y0 Z0\nM30\n");
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G90 G54.1 P4 G0 X100. Y0 Z0\nM30\n", job).has("E-WCS"));
  EXPECT_THAT(
      rewrite(scaled_machine(), "G21 G90 G54.1 P4 G0 X100. Y0 Z0\nM30\n", job).report.diagnostics[0].fix,
      testing::HasSubstr("--offset G54.1P4=X"));
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G90 G54.1 P301 G0 X100. Y0 Z0\nM30\n", job).has("E-WCS"));
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G90 G54.1 G0 X100. Y0 Z0\nM30\n", job).has("E-WCS"));
  job.setup.profile = embedded_profile("haas");
  EXPECT_EQ(rewrite(scaled_machine(), "G21 G90 G154 P3 G0 X100. Y0 Z0\nM30\n", job).text,
            "G21 G90 G154 P3 G0 X99.990 Y0 Z0\nM30\n");
  EXPECT_EQ(rewrite(scaled_machine(), "G21 G90 G112 G0 X100. Y0 Z0\nM30\n", job).text,
            "G21 G90 G112 G0 X99.990 Y0 Z0\nM30\n");
}

TEST(Dialects, WorkOffsetsSetByTheProgramAreFollowed) {
  EXPECT_EQ(body("G21 G90 G10 L2 P1 X100. Y0 Z0\nG54 G0 X100. Y0 Z0\nM30\n", "fanuc"),
            "G21 G90 G10 L2 P1 X100. Y0 Z0\nG54 G0 X99.990 Y0 Z0\nM30\n");
  EXPECT_EQ(body("G21 G90 G10 L20 P2 X100. Y0 Z0\nG54.1 P2 G0 X100. Y0 Z0\nM30\n", "fanuc"),
            "G21 G90 G10 L20 P2 X100. Y0 Z0\nG54.1 P2 G0 X99.990 Y0 Z0\nM30\n");
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G90 G10 L2 P0 X1. Y0 Z0\nM30\n", job_for("fanuc")).has("E-G10"))
      << "the external offset";
  EXPECT_TRUE(rewrite(scaled_machine(), "G90 G10 L2 P7 X1. Y0 Z0\nM30\n", job_for("grbl")).has("E-G10"));
}

TEST(Dialects, ARotationTurnsTheCorrectionBack) {
  // G68 R90 about the origin: program Y is machine -X, so the error of X is taken out of Y.
  const std::string program =
      "G21 G90 G17 G0 X0 Y0 Z0\nG68 X0 Y0 R90.\nG0 X0 Y100.\nG1 X10. Y100. F500\nG69\nG0 X0 Y0\nM30\n";
  EXPECT_EQ(
      body(program, "fanuc"),
      "G21 G90 G17 G0 X0 Y0 Z0\nG68 X0 Y0 R90.\nG0 X0 Y99.995\nG1 X10. Y99.995 F500\nG69\nG0 X0 Y0\nM30\n");
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G90 G17 G0 X0 Y0 Z0\nG68 R90.\nM30\n", job_for("fanuc"))
                  .has("E-ROTATION"));
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G90 G17 G0 X0 Y0 Z0\nG68 X0 Y0 R90.\nG1 X10. F50\nM30\n",
                      job_for("fanuc"))
                  .has("E-POS"));
  EXPECT_TRUE(
      rewrite(scaled_machine(), "G21 G90 G17 G0 X0 Y0 Z0\nG68 X0 Y0 R90.\nG55\nM30\n", job_for("fanuc"))
          .has("E-ROTATION"));
}

TEST(Dialects, ARotationTurnsAboutItsCentre) {
  // about (50, 0) by 180 degrees: program X100 is machine X0, program X0 machine X100
  const std::string program = "G21 G90 G17 G0 X0 Y0 Z0\nG68 X50. Y0 R180.\nG0 X100. Y0\nG0 X0 Y0\nM30\n";
  EXPECT_EQ(body(program, "fanuc"),
            "G21 G90 G17 G0 X0 Y0 Z0\nG68 X50. Y0 R180.\nG0 X100. Y0\nG0 X0.005 Y0\nM30\n");
}

TEST(Dialects, AnOffsetThatMayMoveTheAxisLeavesItUnknown) {
  const std::string known = "G21 G90 G0 X0 Y0 Z50.\nG43 H1 Z10.\nG1 X100. F500\nM30\n";
  EXPECT_TRUE(rewrite(scaled_machine(), known, job_for("fanuc")).report.complete);
  const std::string unknown = "G21 G90 G0 X0 Y0 Z50.\nG43 H1\nG1 X100. F500\nM30\n";
  EXPECT_TRUE(rewrite(scaled_machine(), unknown, job_for("fanuc")).has("E-POS"));
  EXPECT_TRUE(
      rewrite(scaled_machine(), "G21 G90 G0 X0 Y0 Z50.\nG43 Z10.\nM30\n", job_for("fanuc")).has("E-TOOL"))
      << "H is missing";
}

TEST(Dialects, AToolOffsetActsOnZOnly) {
  // Tool 2 has an offset of 7 mm in X, which this control does not apply.
  EXPECT_EQ(body("G21 G90 G0 X100. Y0 Z50.\nG43 H2 Z10.\nM30\n", "fanuc"),
            "G21 G90 G0 X99.995 Y0 Z50.\nG43 H2 Z10.\nM30\n");
}

TEST(Dialects, AfterAReferenceReturnTheOffsetMustBeNamedAgain) {
  const std::string start = "G21 G90 G0 X0 Y0 Z50.\nG43 H1 Z10.\nG0 G91 G28 Z0\nG90 G0 X5. Y0\n";
  EXPECT_TRUE(rewrite(scaled_machine(), start + "Z5.\nM30\n", job_for("fanuc")).has("E-TOOL"));
  EXPECT_TRUE(
      rewrite(scaled_machine(), start + "G43 H1 Z5.\nG1 X9. F50\nM30\n", job_for("fanuc")).report.complete);
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G90 G0 X0 Y0 Z50.\nG28\nM30\n", job_for("fanuc")).has("E-BLOCK"))
      << "no axis";
}

TEST(Dialects, ADwellInXIsNoMotion) {
  EXPECT_EQ(body("G21 G90 G0 X100. Y0 Z0\nG4 X1.5\nG1 X50. F100\nM30\n", "fanuc"),
            "G21 G90 G0 X99.995 Y0 Z0\nG4 X1.5\nG1 X49.998 F100\nM30\n");
  EXPECT_TRUE(
      rewrite(scaled_machine(), "G21 G90 G0 X1. Y0 Z0\nG4 X1. Y2.\nM30\n", job_for("fanuc")).has("E-WORD"));
}

TEST(Dialects, SmoothingIsCopiedAndReported) {
  for (const auto& [dialect, code] :
       {std::pair{"fanuc", "G5.1 Q1"}, {"haas", "G187 P3 E0.01"}, {"fanuc", "G05 P10000"}}) {
    const auto result =
        rewrite(scaled_machine(), std::string("G21 G90 G0 X0 Y0 Z0\n") + code + "\nM30\n", job_for(dialect));
    EXPECT_TRUE(result.report.complete) << result.findings();
    EXPECT_TRUE(result.has("W-SMOOTH")) << code;
    EXPECT_THAT(result.text, HasSubstr(code));
  }
  EXPECT_TRUE(rewrite(scaled_machine(), "G0 X0 Y0 Z0\nG64 P0.05\nM30\n").has("W-SMOOTH"));
  EXPECT_FALSE(rewrite(scaled_machine(), "G0 X0 Y0 Z0\nG64 P0.0005\nM30\n").has("W-SMOOTH"));
}

/// What the program says of the smoothing's tolerance is held against ours, 1 um, in the units in force.
TEST(Dialects, SmoothingWithinTheToleranceIsNotReported) {
  struct Case {
    const char* dialect;
    const char* code;
    bool reported;
  };
  for (const Case& c : {Case{"linuxcnc", "G64", true},
                        {"linuxcnc", "G64 P0.0005 Q0.002", true},
                        {"linuxcnc", "G20 G64 P0.0001", true},
                        {"linuxcnc", "G20 G64 P0.00003", false},
                        {"linuxcnc", "G61", false},
                        {"fanuc", "G64", false},
                        {"fanuc", "G5.1 Q0", false},
                        {"fanuc", "G8 P1", true},
                        {"fanuc", "G8 P0", false},
                        {"haas", "G187 P1", true},
                        {"haas", "G187 E0.0008", false},
                        {"siemens", "CTOL=0.01", true},
                        {"siemens", "CTOL = 0.0005", false},
                        {"siemens", "CYCLE832(0.01,1,1)", true},
                        {"siemens", "CYCLE832(0.0008,1)", false},
                        {"siemens", "G642", true},
                        {"siemens", "COMPCAD", true},
                        {"siemens", "OTOL=0.0001", true},
                        {"siemens", "COMPOF", false}}) {
    const auto result =
        rewrite(scaled_machine(), std::string("G90\n") + c.code + "\nM30\n", job_for(c.dialect));
    EXPECT_TRUE(result.report.complete) << c.code << result.findings();
    EXPECT_EQ(result.has("W-SMOOTH"), c.reported) << c.dialect << " " << c.code << result.findings();
  }
}

TEST(Dialects, SiemensWordsThatSayWhatTheyAreStayAsTheyAre) {
  const auto run = [](const std::string& body) {
    return rewrite(scaled_machine(), "G71 G90 G54 D0\nG0 X0 Y0 Z0\n" + body + "M30\n", job_for("siemens"));
  };
  // X is 5e-5 too long: 100 becomes 99.995, and the way back from there 49.9975
  const auto result = run("G1 X=IC(100) Y=AC(0) F100\nX=IC( -50 ) Z1\nY=IC(3)\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_THAT(result.text, HasSubstr("G1 X=IC(99.9950) Y=AC(0) F100\nX=IC( -49.9975 ) Z1\nY=IC(3)\n"));
  EXPECT_TRUE(run("G91\nG1 X=AC(5) F100\n").has("E-BLOCK"));
  EXPECT_TRUE(run("G1 F100\nG91\nX=AC(5)\n").has("E-BLOCK"));
  EXPECT_TRUE(run("TRANS X=IC(5)\n").has("E-BLOCK"));
  EXPECT_TRUE(run("SUPA G0 X=IC(5) D0\n").has("E-BLOCK"));
  EXPECT_TRUE(run("AROT R90\n").has("E-EXPR"));
}

// The start is 99.995, the end 119.994, and with X 5e-5 too long the centre belongs at 109.9945.
TEST(Dialects, SiemensCentresMayBePlaces) {
  const auto run = [](const std::string& body) {
    return rewrite(scaled_machine(), "G71 G90 G54 D0\nG0 X100 Y0 Z0\n" + body + "M30\n", job_for("siemens"));
  };
  const auto result = run("G2 X120 Y0 I=AC(110) J=AC(0) F100\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_THAT(result.text, HasSubstr("G0 X99.9950 Y0 Z0\nG2 X119.9940 Y0 I=AC(109.994"));
  EXPECT_TRUE(run("G2 X120 Y0 I=AC(110) F100\n").has("E-ARC"));
  EXPECT_TRUE(run("G91\nG2 X20 Y0 I=AC(110) J=AC(0) F100\n").has("E-BLOCK"));
}

TEST(Dialects, TextOfAnotherControlIsRefused) {
  EXPECT_TRUE(rewrite(scaled_machine(), "G21 G90 ; comment\nM30\n", job_for("fanuc")).has("E-CHAR"));
  EXPECT_TRUE(rewrite(scaled_machine(), "%\nM30\n%\n", job_for("grbl")).has("E-CHAR"));
  EXPECT_TRUE(rewrite(scaled_machine(), "O1\nM30\n", job_for("grbl")).has("E-OWORD"));
  EXPECT_EQ(body("%\n:0097(NAME)\nG21\nM30\n%\n", "fanuc"), "%\n:0097(NAME)\nG21\nM30\n%\n");
  EXPECT_EQ(body("/G0 X100.\nM30\n", "grbl"), "/G0 X99.9950\nM30\n") << "Grbl runs such blocks";
}

struct Refused {
  const char* dialect;
  const char* line;
  const char* code;
};
class DialectRefuses : public ::testing::TestWithParam<Refused> {};

TEST_P(DialectRefuses, WhatItDoesNotUnderstand) {
  const auto result =
      rewrite(scaled_machine(), std::string("G21 G90 G0 X0. Y0. Z50.\n") + GetParam().line + "\nM30\n",
              job_for(GetParam().dialect));
  EXPECT_FALSE(result.report.complete);
  EXPECT_TRUE(result.has(GetParam().code)) << result.findings();
  EXPECT_THAT(result.findings(), HasSubstr("part.ngc:2:"));
  EXPECT_THAT(result.findings(), ::testing::AllOf(HasSubstr("why:"), HasSubstr("fix:")));
}

INSTANTIATE_TEST_SUITE_P(
    Codes, DialectRefuses,
    ::testing::Values(
        Refused{"fanuc", "G41 D9", "E-CUTCOM"}, Refused{"fanuc", "G92 X0", "E-GCODE"},
        Refused{"fanuc", "G51 X0 Y0 P1.5", "E-FRAME"}, Refused{"fanuc", "G51.1 Z0", "E-WORD"},
        Refused{"fanuc", "G7.1 C10.", "E-FRAME"}, Refused{"fanuc", "G107 C10.", "E-FRAME"},
        Refused{"fanuc", "G12.1", "E-FRAME"}, Refused{"fanuc", "G112", "E-FRAME"},
        Refused{"fanuc", "G16", "E-FRAME"}, Refused{"fanuc", "G68.2 X0 Y0 Z0 I0 J30. K0", "E-PLANE"},
        Refused{"fanuc", "G5.2 P3 K0 X0 Y0 Z0", "E-GCODE"}, Refused{"fanuc", "G60 X10.", "E-GCODE"},
        Refused{"fanuc", "G31 Z-5. F50", "E-GCODE"}, Refused{"fanuc", "G65 P9010", "E-GCODE"},
        Refused{"fanuc", "M98 P1000", "E-OWORD"}, Refused{"fanuc", "M99", "E-OWORD"},
        Refused{"fanuc", "M77", "E-MCODE"}, Refused{"fanuc", "G87 Z-5. R2. Q1. F50", "E-CYCLE"},
        Refused{"fanuc", "G33 Z-5. F1.", "E-GCODE"}, Refused{"fanuc", "X#1", "E-EXPR"},
        Refused{"fanuc", "G2 X10. P2 I5.", "E-WORD"}, Refused{"fanuc", "G81 Z-5. R60. F50", "E-CYCLE"},
        Refused{"fanuc", "G54.1 P1 G55", "E-BLOCK"}, Refused{"fanuc", "G5 P10000 X1.", "E-BLOCK"},
        Refused{"fanuc", "T1 M6 X5.", "E-AUX"}, Refused{"fanuc", "G18 G81 X5. Y-5. R2. F50", "E-CYCLE"},
        Refused{"haas", "G13 I10. F50 D1", "E-CYCLE"}, Refused{"haas", "G70 I10. J0 L4", "E-CYCLE"},
        Refused{"haas", "G150 P1", "E-CYCLE"}, Refused{"haas", "G101 X0", "E-FRAME"},
        Refused{"haas", "G52 X1.", "E-GCODE"}, Refused{"haas", "M97 P10", "E-MCODE"},
        Refused{"haas", "G54.1 P1", "E-GCODE"}, Refused{"haas", "G5.1 Q1", "E-GCODE"},
        Refused{"grbl", "G81 Z-5 R2 F50", "E-CYCLE"}, Refused{"grbl", "G43 H1", "E-GCODE"},
        Refused{"grbl", "G43.1 X1", "E-WORD"}, Refused{"grbl", "G90.1", "E-GCODE"},
        Refused{"grbl", "M6 T1", "E-MCODE"}, Refused{"grbl", "G64 P0.1", "E-GCODE"},
        Refused{"grbl", "G2 X10 P2 I5", "E-WORD"}, Refused{"grbl", "G38.2 Z-5 F50", "E-GCODE"},
        Refused{"grbl", "G52 X1", "E-GCODE"}, Refused{"grbl", "G1 X5 A10 F50", "E-ROTARY"},
        Refused{"grbl", "G10 L2 P1 X1 R5", "E-WORD"}, Refused{"grbl", "G2 X10.1 Y0 I5 J0 F100", "E-ARC"},
        Refused{"grblhal", "G84 Z-5 R2 F50", "E-CYCLE"}, Refused{"iso", "G2 X10. R5. F50", "E-WORD"}));

RewriteJob siemens_job() {
  RewriteJob job = job_for("siemens");
  job.setup.tools[2].comment = "name=\"MILL 10\"";
  job.setup.further_offsets[5] = WorkOffset{{100, 0, 0}, 0};
  return job;
}
std::string siemens(const std::string& program) {
  return rewrite(scaled_machine(), program, siemens_job()).text;
}

TEST(Siemens, NumbersAreReplacedWhereTheyStand) {
  EXPECT_EQ(siemens("G71 G90 G54 D0\nG0 X = 100 Y=0 Z0 ; c\nM30\n"),
            "G71 G90 G54 D0\nG0 X = 99.9950 Y=0 Z0 ; c\nM30\n");
  EXPECT_EQ(siemens("G700 G90 G54 D0\nG0 X=4 Y0 Z0\nM30\n"), "G700 G90 G54 D0\nG0 X=3.99980 Y0 Z0\nM30\n")
      << "0.0002 inch are 5.08 um";
}

TEST(Siemens, ARadiusWithANameIsKeptOrBecomesACentre) {
  // X is scaled by 5e-5: the half circle about (110, 0) stays one within 0.25 um
  const std::string text = siemens("G71 G90 G54 D0\nG0 X100 Y0 Z0\nG2 X120 Y0 CR=10 F500\nM30\n");
  EXPECT_THAT(text, HasSubstr("G2 X119.9940 Y0"));
  EXPECT_THAT(text, ::testing::AnyOf(HasSubstr("CR=10"), HasSubstr("I9.99")));
  EXPECT_THAT(text, Not(HasSubstr("CI")));
}

TEST(Siemens, FramesOfWordsAreFollowed) {
  // TRANS X100: program X0 is 100 mm, where X goes 5 um too far
  EXPECT_EQ(
      siemens("G71 G90 G54 D0\nG0 X0 Y0 Z0\nTRANS X100\nG0 X0\nATRANS X=100\nG0 X0\nTRANS\nG0 X0\nM30\n"),
      "G71 G90 G54 D0\nG0 X0 Y0 Z0\nTRANS X100\nG0 X-0.0050\nATRANS X=100\nG0 X-0.0100\nTRANS\nG0 X0\nM30\n");
  // turned by 90 degrees about X100: program Y is machine -X from there
  EXPECT_EQ(
      siemens("G71 G90 G54 D0\nG0 X0 Y0 Z0\nTRANS X100\nAROT RPL=90\nG0 X0 Y-100\nROT\nG0 X0 Y0\nM30\n"),
      "G71 G90 G54 D0\nG0 X0 Y0 Z0\nTRANS X100\nAROT RPL=90\nG0 X0 Y-99.9900\nROT\nG0 X0 Y0\nM30\n");
  EXPECT_EQ(siemens("G71 G90 G54 D0\nG0 X0 Y0 Z0\nTRANS X100\nAROT Z90\nG0 X0 Y-100\nROT\nG0 X0 Y0\nM30\n"),
            "G71 G90 G54 D0\nG0 X0 Y0 Z0\nTRANS X100\nAROT Z90\nG0 X0 Y-99.9900\nROT\nG0 X0 Y0\nM30\n");
  EXPECT_EQ(siemens("G71 G90 G54 D0\nG505 G0 X0 Y0 Z0\nM30\n"),
            "G71 G90 G54 D0\nG505 G0 X-0.0050 Y0 Z0\nM30\n");
}

TEST(Siemens, ToolsHaveNamesAndEdges) {
  // the table's Z offset of MILL 10 is 80 mm: EXZ would show it, so the errors are of Z here
  const Machine leaning = three_axes({{"EXZ", poly(2, {0, 1e-4})}});
  const std::string program = "G71 G90 G54\nT=\"MILL 10\"\nM6\nD1\nG0 X0 Y0 Z0\nM30\n";
  EXPECT_THAT(rewrite(leaning, program, siemens_job()).text, HasSubstr("G0 X-0.0080 Y0 Z0"));
  EXPECT_TRUE(rewrite(leaning, "G71 G90 G54\nT2 M6\nG0 X0 Y0 Z0\nM30\n", siemens_job()).has("E-TOOL"))
      << "D is missing";
  EXPECT_TRUE(rewrite(leaning, "G71 G90 G54\nT2 M6\nD2\nM30\n", siemens_job()).has("E-TOOL"));
  EXPECT_TRUE(rewrite(leaning, "G71 G90 G54\nT2 M6\nD1\nG18 G0 X0 Y0 Z0\nM30\n", siemens_job()).has("E-TOOL"))
      << "another axis";
}

TEST(Siemens, AToolThatIsNotKnownIsRefused) {
  for (const char* tool : {"T=\"MILL 11\"", "T1.5", "T-1"}) {
    const auto result =
        rewrite(scaled_machine(), std::string("G71 G90 G54\n") + tool + "\nM30\n", siemens_job());
    EXPECT_FALSE(result.report.complete) << tool;
    EXPECT_TRUE(result.has("E-TOOL")) << tool;
  }
}

TEST(Siemens, MachineCoordinatesNeedNoOffset) {
  EXPECT_EQ(siemens("G71 G90 G54 T2 M6\nD1\nG0 X100 Y0 Z0\nG0 SUPA Z200 D0\nM30\n"),
            "G71 G90 G54 T2 M6\nD1\nG0 X99.9950 Y0 Z0\nG0 SUPA Z200 D0\nM30\n");
  EXPECT_TRUE(
      rewrite(scaled_machine(), "G71 G90 G54 T2 M6\nD1\nG0 X100 Y0 Z0\nSUPA Z200\nM30\n", siemens_job())
          .has("E-G53"));
}

TEST(Siemens, ADwellInFIsNoFeed) {
  RewriteJob job = siemens_job();
  const auto result =
      rewrite(scaled_machine(), "G71 G90 G54 D0\nG0 X0 Y0 Z0\nG1 X10 F500\nG4 F2\nX20\nM30\n", job);
  EXPECT_TRUE(result.report.complete) << result.findings();
}

TEST(Siemens, TheWorkOffsetMustBeStated) {
  const auto code_of = [](const std::string& program) {
    const auto result = rewrite(scaled_machine(), program, siemens_job());
    return result.report.complete ? std::string() : result.report.diagnostics.front().code;
  };
  EXPECT_EQ(code_of("G71 G90 D0\nG0 X0 Y0 Z0\nM30\n"), "E-START");
  EXPECT_EQ(code_of("G71 G90 D0\nSUPA G0 Z0\nG54\nG0 X0 Y0 Z0\nM30\n"), "")
      << "machine coordinates need none";
  EXPECT_EQ(code_of("G71 G90 G505 D0\nG0 X0 Y0 Z0\nM30\n"), "");
}

TEST(Siemens, IncrementsBehindAMovedZeroAreRefused) {
  const auto code_of = [](const std::string& rest) {
    const auto result =
        rewrite(scaled_machine(), "G71 G90 G54 D0\nG0 X0 Y0 Z0\n" + rest + "M30\n", siemens_job());
    return result.report.complete ? std::string() : result.report.diagnostics.front().code;
  };
  for (const char* shift : {"G505\n", "TRANS X100\n", "SUPA X5\n", "TRANS X5\nG90 G0 X0\nTRANS\n"}) {
    EXPECT_EQ(code_of(std::string(shift) + "G91 G1 X10 F500\n"), "E-POS") << shift;
    EXPECT_EQ(code_of(std::string(shift) + "G90 G0 X0\nG91 G1 X10 F500\n"), "") << shift;
    EXPECT_EQ(code_of(std::string(shift) + "G91 G0 Y10\n"), "") << shift << "the zero of Y stands";
  }
  EXPECT_EQ(code_of("G54\nG91 G1 X10 F500\n"), "") << "the same zero";
}

TEST(Subprograms, CalledOnceAreRewrittenWhereTheyStand) {
  const std::string start = "%\nO1 (MAIN)\nG21 G90 G0 X100. Y0. Z0.\n", end = "M30\nO2 (SUB)\n";
  // the subprogram begins at X100 in G91, and what follows the call begins where it ended
  const std::string program =
      start + "M98 P2\nG90 G1 X100. F100\n" + end + "G91 G1 X100. F100\nY1.\nM99\n(behind)\n%\n";
  const auto result = rewrite(scaled_machine(), program, job_for("fanuc"));
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, "%\nO1 (MAIN)\nG21 G90 G0 X99.995 Y0. Z0.\nM98 P2\nG90 G1 X99.995 F100\n" + end +
                             "G91 G1 X99.995 F100\nY1.\nM99\n(behind)\n%\n");
  EXPECT_EQ(result.report.lines_out, result.report.lines_in);
}

TEST(Subprograms, OneMayCallAnother) {
  const auto result = rewrite(
      scaled_machine(), "G21 G90 G0 X0. Y0. Z0.\nM98 P3\nM30\nO2\nG0 X200.\nM99\nO3\nG0 X100.\nM98 P2\nM99\n",
      job_for("fanuc"));
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text,
            "G21 G90 G0 X0. Y0. Z0.\nM98 P3\nM30\nO2\nG0 X199.990\nM99\nO3\nG0 X99.995\nM98 P2\nM99\n");
}

TEST(Subprograms, WhatIsNotSureIsRefused) {
  const std::string start = "G21 G90 G0 X0. Y0. Z0.\n", sub = "O2\nX1.\nM99\n";
  const auto code_of = [&](const std::string& rest) {
    const auto result = rewrite(scaled_machine(), start + rest, job_for("fanuc"));
    return result.report.complete ? std::string() : result.report.diagnostics.front().code;
  };
  EXPECT_EQ(code_of("M98 P2\nM30\n" + sub), "");
  for (const char* rest :
       {"M98 P2\nM98 P2\nM30\nO2\nX1.\nM99\n", "M98 P2 L2\nM30\nO2\nX1.\nM99\n",
        "M98 P20002\nM30\nO2\nX1.\nM99\n", "M98 P3\nM30\nO2\nX1.\nM99\n", "M98 P2 X1.\nM30\nO2\nX1.\nM99\n",
        "M98 P2\nM30\nO2\nX1.\n", "M98 P2\nM30\nO2\nX1.\nM30\nM99\n", "M98 P2\nM30\nO2 X1.\nM99\n", "M99\n",
        "M98 P2\nM30\nO2\nM99\nO2\nM99\n", "M98 P2\nM30\n%\nO2\nX1.\nM99\n", "M98 P2\nM30\nO2\nM98 P2\nM99\n",
        "M98 P2\nM30\nO2\nM99 P10\n", "M98 P2 M30\nO2\nX1.\nM99\n"})
    EXPECT_THAT(code_of(rest), ::testing::AnyOf("E-OWORD", "E-WORD", "E-AUX")) << rest;
}

}  // namespace
}  // namespace abbe::testing
