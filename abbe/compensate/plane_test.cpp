// Tilted planes, scales and mirrors: what is written for a line of them, by hand.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "abbe/compensate/rewrite_fixture.h"
#include "abbe/machine/read_machine.h"
#include "abbe/machine/read_profile.h"

namespace abbe::testing {
namespace {

using ::testing::HasSubstr;

Machine machine_of(const std::string& text) {
  auto parsed = read_machine({"m.toml", text}, std::nullopt, [](const std::string&) { return std::nullopt; });
  EXPECT_TRUE(parsed.value) << text;
  return *parsed.value;
}

/// A on the bed carries C; the A axis passes 20 mm behind and 50 mm below the zero of the machine.
std::string table(const std::string& errors, const std::string& control = "") {
  return R"(format = 1
[machine]
chain = "w C A b Y X Z t"
[axis.A]
direction = [1, 0, 0]
origin = [0, 20, -50]
range = [-120, 30]
[axis.C]
direction = [0, 0, 1]
[control]
mode = "axis"
codes = { "G43.4" = "tcp" }
)" + control +
         "[control.axis.C]\nturning = \"shortest\"\n[errors]\n" + errors;
}

/// B carries the tool, 100 mm from its axis.
std::string head(const std::string& errors) {
  return R"(format = 1
[machine]
chain = "w b X Y Z B t"
[axis.B]
direction = [0, 1, 0]
[tool]
length = 100
[control]
mode = "axis"
[errors]
)" + errors;
}

RewriteJob fanuc() {
  RewriteJob job = plain_job();
  job.setup.profile = embedded_profile("fanuc");
  job.setup.tools[1] = ToolEntry{1, 1, {0, 0, 100}, 100.0, 10, ""};
  return job;
}

constexpr const char* kStart = "G21 G90 G94 G17 G54\n";

Rewritten run(const std::string& machine, const std::string& program, const RewriteJob& job = fanuc()) {
  return rewrite(machine_of(machine), kStart + program + "M30\n", job);
}

std::string last_but_end(const Rewritten& result) {
  EXPECT_TRUE(result.report.complete) << result.findings();
  const std::string& text = result.text;
  const std::size_t end = text.rfind("M30\n");
  if (end == std::string::npos || end == 0) return text;
  const std::size_t begin = text.rfind('\n', end - 2);
  return text.substr(begin + 1, end - begin - 1);
}

// Tool direction in the work (0, sin a, cos a), plane normal Rx(30) z = (0, -1/2, cos 30): A-30. On the
// machine y = 100 + 20 - 20 cos 30 + 50 sin 30 = 127.6795, which an error of 0.5 um per mm asks for at
// 127.6157.
TEST(TiltedPlane, CorrectsAlongTheAxesOfThePlane) {
  const std::string errors = "EYY = { poly = [0, 0.5] }\n";
  EXPECT_EQ(last_but_end(run(table(errors),
                             "G0 A-30. C0.\nG68.2 X0. Y0. Z0. I0. J30. K0.\nG53.1\n"
                             "G0 X0. Y100. Z0.\n")),
            "G0 X0. Y99.936 Z0.\n");
}

// C90 A-30: the tool points along (-1/2, 0, cos 30), which is Rz(-90) Rx(30) z. K90 turns the plane's X into
// the machine's Y. With the angles taken in another order or the other way round the tool is not square to
// it.
TEST(TiltedPlane, EulerAnglesTurnAboutZXZ) {
  const std::string errors = "EYY = { poly = [0, 0.5] }\n";
  EXPECT_EQ(last_but_end(run(table(errors),
                             "G0 A-30. C90.\nG68.2 X0. Y0. Z0. I-90. J30. K90.\nG53.1\n"
                             "G0 X100. Y0. Z0.\n")),
            "G0 X99.936 Y0. Z0.\n");
  for (const char* wrong : {"I90. J30. K90.", "I-90. J-30. K90.", "I30. J-90. K90.", "I90. J30. K-90."}) {
    const auto refused = run(table(errors), std::string("G0 A-30. C90.\nG68.2 X0. Y0. Z0. ") + wrong +
                                                "\nG53.1\nG0 X100. Y0. Z0.\n");
    EXPECT_TRUE(refused.has("E-PLANE")) << wrong << refused.findings();
  }
}

// B30 lays the tool along (1/2, 0, cos 30) = Rz(90) Rx(30) z, and with K-90 the plane is Ry(30). X stands at
// 100 cos 30 + 100 sin 30 = 136.6025 (the tool is 100 long): its correction c is -0.068267, in the plane
// c cos 30 and c sin 30.
TEST(TiltedPlane, OnAHeadTheToolLengthLeans) {
  const std::string errors = "EXX = { poly = [0, 0.5] }\n";
  EXPECT_EQ(last_but_end(run(head(errors),
                             "G0 B30.\nG68.2 X0. Y0. Z0. I90. J30. K-90.\nG53.1\n"
                             "G43 H1\nG0 X100. Y0. Z0.\n")),
            "G0 X99.941 Y0. Z-0.034\n");
}

// X and Y before the tool length, Z with it: coordinates of the plane are known one by one.
TEST(TiltedPlane, CoordinatesAreCommandedOneByOne) {
  const std::string errors = "EXX = { poly = [0, 0.5] }\n";
  const auto result = run(head(errors),
                          "G0 B30.\nG68.2 X0. Y0. Z0. I90. J30. K-90.\nG53.1\n"
                          "G0 X100. Y0.\nG43 H1 Z0.\nG0 X100.\n");
  EXPECT_EQ(last_but_end(result), "G0 X99.941\n") << result.text;
  EXPECT_THAT(result.text, HasSubstr("G0 X100. Y0.\nG43 H1 Z-0.034 X99.941\n")) << result.text;
}

// PLANE SPATIAL turns about the fixed axes, X first: Rz(-90) Rx(30), so that the plane's X is the machine's X
// and y = 127.6795 as above. The rotary axes are turned by the program, and are not corrected.
TEST(TiltedPlane, SpatialAnglesTurnAboutTheFixedAxes) {
  RewriteJob job = plain_job();
  job.setup.profile = embedded_profile("heidenhain");
  const auto written = [&](const std::string& words, const std::string& control = "") {
    const auto result = rewrite(machine_of(table("EYY = { poly = [0, 0.5] }\n", control)),
                                "0 BEGIN PGM P MM\n" + words + "9 END PGM P MM\n", job);
    return result.report.complete ? result.text : result.findings();
  };
  const std::string plane = "1 PLANE SPATIAL SPA+30 SPB+0 SPC-90 STAY\n";
  EXPECT_THAT(written(plane + "2 L A-30 C+90 R0 FMAX\n3 L X+0 Y+100 Z+0 R0 FMAX\n"),
              HasSubstr("2 L A-30 C+90 R0 FMAX\n3 L X+0 Y+99.9362 Z+0 R0 FMAX\n"));
  EXPECT_THAT(written(plane + "2 L A-30 C-90 R0 FMAX\n3 L X+0 Y+100 Z+0 R0 FMAX\n"), HasSubstr("E-PLANE"));
  EXPECT_THAT(written(plane + "3 L X+0 Y+100 Z+0 R0 FMAX\n"), HasSubstr("E-PLANE"));
  const std::string turn = "1 PLANE SPATIAL SPA+30 SPB+0 SPC-90 TURN FMAX SEQ- COORD ROT\n";
  EXPECT_THAT(written(turn + "3 L X+0 Y+100 Z+0 R0 FMAX\n", "tilt_solution = \"A+\"\n"),
              HasSubstr("3 L X+0 Y+99.9362 Z+0 R0 FMAX\n"));
  EXPECT_THAT(written(turn + "3 L X+0 Y+100 Z+0 R0 FMAX\n"), HasSubstr("E-PLANE"));
  const std::string nearer = "1 L A-30 C+90 R0 FMAX\n2 PLANE SPATIAL SPA+30 SPB+0 SPC-90 TURN FMAX\n";
  EXPECT_THAT(written(nearer + "3 L X+0 Y+100 Z+0 R0 FMAX\n", "tilt_solution = \"A+\"\n"),
              HasSubstr("3 L X+0 Y+99.9362 Z+0 R0 FMAX\n"))
      << "without SEQ the tool stays where it stands";
  EXPECT_THAT(written("1 PLANE SPATIAL SPA+30 SPB+0 SPC-90 TURN FMAX\n3 L X+0 Y+100 Z+0 R0 FMAX\n",
                      "tilt_solution = \"A+\"\n"),
              HasSubstr("E-PLANE"));
  EXPECT_THAT(written("1 PLANE EULER EULPR+10 EULNU+20 EULROT+30 STAY\n"), HasSubstr("E-PLANE"));
  EXPECT_THAT(written("1 PLANE SPATIAL SPA+30 SPC-90 STAY\n"), HasSubstr("E-PLANE"));
  EXPECT_THAT(written(plane + "2 L A-30 C+90 R0 FMAX\n3 L X+0 Y+100 Z+0 R0 FMAX\n4 PLANE RESET STAY\n"
                              "5 L X+1 R0 F100\n"),
              HasSubstr("E-POS"));
}

// CYCLE800 axis by axis: MODE 57 turns about X, the new Y, the new Z; 27 about Z, Y, X. Rz(-90) Rx(30) is 27
// with -90, 0, 30: as above.
TEST(TiltedPlane, SwivelsAxisByAxis) {
  RewriteJob job = plain_job();
  job.setup.profile = embedded_profile("siemens");
  const auto written = [&](const std::string& words, const std::string& control = "") {
    const auto result = rewrite(machine_of(table("EYY = { poly = [0, 0.5] }\n", control)),
                                "G17 G90 G94 G710 G54 D0\n" + words + "M30\n", job);
    return result.report.complete ? result.text : result.findings();
  };
  const std::string plane = "CYCLE800(0,\"T\",0,27,0,0,0,-90,0,30,0,0,0,0)\n", cut = "G0 X0 Y100 Z0\n";
  EXPECT_THAT(written(plane + "G0 A-30 C90\n" + cut), HasSubstr("G0 A-30 C90\nG0 X0 Y99.9362 Z0\n"));
  // the same plane begins 40 mm farther on its Y: y is 167.6795
  EXPECT_THAT(written("CYCLE800(0,\"T\",0,27,,,,-90,0,30,0,40,0,0)\nG0 A-30 C90\n" + cut),
              HasSubstr("G0 X0 Y99.9162 Z0\n"));
  EXPECT_THAT(written("CYCLE800(0,\"T\",0,27,0,0,0,-90,0,30,0,0,0,-1)\n" + cut, "tilt_solution = \"A-\"\n"),
              HasSubstr("G0 X0 Y99.9362 Z0\n"));
  EXPECT_THAT(written("CYCLE800(0,\"T\",0,57,0,0,0,30,0,0,0,0,0,0)\nG0 A-30 C0\n" + cut),
              HasSubstr("G0 X0 Y99.9362 Z0\n"));
  for (const char* bad :
       {"CYCLE800(0,\"T\",0,57,0,0,0,-90,0,30,0,0,0,0)", "CYCLE800(0,\"T\",1,27,0,0,0,-90,0,30,0,0,0,0)",
        "CYCLE800(0,\"T\",0,192,0,0,0,-30,90,0,0,0,0,0)", "CYCLE800(0,\"T\",0,27,0,0,0,-90,0,30)",
        "CYCLE800(0,\"0\",0,27,0,0,0,-90,0,30,0,0,0,0)", "CYCLE800(0,\"T\",0,27,0,0,0,R1,0,30,0,0,0,0)",
        "TRANS X1\nCYCLE800(0,\"T\",0,27,0,0,0,-90,0,30,0,0,0,0)"})
    EXPECT_THAT(written(bad + ("\nG0 A-30 C90\n" + cut)), HasSubstr("E-PLANE")) << bad;
  EXPECT_THAT(written(plane + "G0 A-30 C90\n" + cut + "CYCLE800()\nG0 X0 Y100 Z0\n"),
              HasSubstr("CYCLE800()\n"));
}

TEST(TiltedPlane, TheOriginCountsInTheWorkOffset) {
  // y = 100 + Rx(-30) (o - (0, 20, -50)) + 20 with o = (0, 40, 0): cos 30 * 20 + sin 30 * 50 + 120 = 162.3205
  const std::string errors = "EYY = { poly = [0, 0.5] }\n";
  EXPECT_EQ(last_but_end(run(table(errors),
                             "G0 A-30. C0.\nG68.2 X0. Y40. Z0. I0. J30. K0.\nG53.1\n"
                             "G0 X0. Y100. Z0.\n")),
            "G0 X0. Y99.919 Z0.\n");
}

TEST(TiltedPlane, ArcsAndHolesAreThoseOfThePlane) {
  const std::string program =
      "G0 A-30. C0.\nG68.2 X0. Y0. Z0. I0. J30. K0.\nG53.1\nG0 X0. Y0. Z5.\nG1 X10. F500.\n"
      "G2 X20. Y0. I5. J0.\nG98 G81 X30. Y10. Z-3. R2.\nY20.\nG80\nG91 G1 Y5.\nG90\nG69\nG0 A0. C0.\n";
  const auto exact = run(table(""), program);
  EXPECT_TRUE(exact.report.complete) << exact.findings();
  EXPECT_EQ(exact.text, kStart + program + "M30\n");
  // nothing leans: only Z 1 um per mm of Y, and Y is 27.6795 + y
  const auto result = run(table("EZY = { poly = [0, 1] }\n"), program);
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_THAT(result.text, HasSubstr("G98 G81 X30. Y10. Z-3.038 R1.962\n")) << result.text;
  EXPECT_THAT(result.text, HasSubstr("Y20. R1.952 Z-3.048\n")) << result.text;
}

TEST(TiltedPlane, IsRefusedWhereTheRotaryAxesAreNotSaid) {
  const std::string plane = "G68.2 X0. Y0. Z0. I0. J30. K0.\n", cut = "G0 X0. Y0. Z5.\n";
  EXPECT_TRUE(run(table(""), "G0 A-29.9 C0.\n" + plane + "G53.1\n" + cut).has("E-PLANE"));
  EXPECT_TRUE(run(table(""), "G0 A30. C0.\n" + plane + "G53.1\n" + cut).has("E-PLANE"));
  EXPECT_TRUE(run(table(""), "G91 G28 A0. C0.\nG90\n" + plane + "G53.1\n" + cut).has("E-PLANE"));
  EXPECT_TRUE(run(table(""), "G0 A-30. C0.\n" + plane + cut).has("E-PLANE"));
  EXPECT_TRUE(run(table(""), "G0 A-30. C0.\nG53.1\n" + cut).has("E-PLANE"));
  EXPECT_TRUE(run(table(""), "G0 A-30. C0.\nG68.2 X0. Y0. I0. J30. K0.\nG53.1\n" + cut).has("E-PLANE"));
  EXPECT_TRUE(run(table(""), "G0 A-30. C0.\n" + plane + "G53.1\n" + cut + "G0 C10.\n").has("E-PLANE"));
  EXPECT_TRUE(run(table(""), "G0 A-30. C0.\n" + plane + "G53.1\n" + cut + "G91 G28 Z0.\n").has("E-ROTATION"));
  EXPECT_TRUE(run(table(""), "G0 A-30. C0.\n" + plane + "G53.1\n" + cut + "G55\n").has("E-ROTATION"));
  EXPECT_TRUE(run(table(""), "G0 A-30. C0.\n" + plane + "G53.1\n" + cut + "G43.4 H1\n").has("E-TCP"));
  EXPECT_TRUE(
      run(table(""), "G0 A-30. C0.\n" + plane + "G53.1\n" + cut + "G69\nG1 X5. F100.\n").has("E-POS"));
}

// The machine file says that A ends below zero: A-30, and C next to where it stands.
TEST(TiltedPlane, TheMachineFileMaySayWhichWayTheAxesStand) {
  const std::string errors = "EYY = { poly = [0, 0.5] }\n";
  const std::string program = "G68.2 X0. Y0. Z0. I-90. J30. K90.\nG53.1\nG0 X100. Y0. Z0.\n";
  EXPECT_EQ(last_but_end(run(table(errors, "tilt_solution = \"A-\"\n"), program)), "G0 X99.936 Y0. Z0.\n");
  // A30 C-90: y of the machine is 20 - 20 cos 30 - 50 sin 30 - x, of which 0.5 um per mm are left out
  EXPECT_EQ(last_but_end(run(table(errors, "tilt_solution = \"A+\"\n"), program)), "G0 X99.939 Y0. Z0.\n");
}

// p' = p + c / P: 200 mm on the machine, 0.1 mm too far.
TEST(Scale, CorrectionsAreDividedByTheFactor) {
  const Machine machine = three_axes({{"EXX", poly(0, {0, 5e-4})}});
  const auto written = [&](const std::string& program) {
    return last_but_end(rewrite(machine, kStart + program + "M30\n", fanuc()));
  };
  EXPECT_EQ(written("G51 X0. Y0. Z0. P2.\nG0 X100. Y0. Z0.\n"), "G0 X99.950 Y0. Z0.\n");
  // about X50: 2 (100 - 50) + 50 = 150 on the machine, 0.075 too far, 0.037 in the program
  EXPECT_EQ(written("G51 X50. Y0. Z0. P2.\nG0 X100. Y0. Z0.\n"), "G0 X99.963 Y0. Z0.\n");
  EXPECT_EQ(written("G51 X0. Y0. Z0. P2.\nG0 X100. Y0. Z0.\nG50\nG0 X100. Y0. Z0.\n"),
            "G0 X99.950 Y0. Z0.\n");
  const auto arc = rewrite(machine,
                           kStart + std::string("G51 X0. Y0. Z0. P2.\nG0 X100. Y0. Z0.\n"
                                                "G2 X110. Y0. I5. J0. F100.\nM30\n"),
                           fanuc());
  EXPECT_TRUE(arc.report.complete) << arc.findings();
  const std::string hole = "G51 X0. Y0. Z0. P2.\nG0 X100. Y0. Z5.\nG98 G81 X1. Y1. Z-1. R1. F100.\n";
  EXPECT_TRUE(rewrite(machine, kStart + hole + "M30\n", fanuc()).has("E-CYCLE"));
}

TEST(Scale, AFactorWithoutAPointIsNotGuessed) {
  const Machine machine = three_axes({{"EXX", poly(0, {0, 5e-4})}});
  const std::string program = kStart + std::string("G51 X0 Y0 Z0 P2000\nG0 X100. Y0 Z0\nM30\n");
  EXPECT_TRUE(rewrite(machine, program, fanuc()).has("E-DECIMAL"));
  RewriteJob job = fanuc();
  Profile profile = *job.setup.profile;
  profile.numbers.scale_words = Profile::Numbers::Scale::thousandths;
  job.setup.profile = std::make_shared<const Profile>(profile);
  EXPECT_EQ(last_but_end(rewrite(machine, program, job)), "G0 X99.950 Y0 Z0\n");
  profile.numbers.scale_words = Profile::Numbers::Scale::hundred_thousandths;
  job.setup.profile = std::make_shared<const Profile>(profile);
  // a factor of 0.02: 2 mm on the machine, 1 um too far, 0.05 mm in the program
  EXPECT_EQ(last_but_end(rewrite(machine, program, job)), "G0 X99.950 Y0 Z0\n");
}

// X100 is -100 on the machine, which ends 0.04 mm too high: the program must say more.
TEST(Mirror, CorrectionsAreTurnedRound) {
  const Machine machine = three_axes({{"EXX", poly(0, {0, 0, 4e-6})}});  // 0.04 mm at 100, on both sides
  const auto written = [&](const std::string& program) {
    return last_but_end(rewrite(machine, kStart + program + "M30\n", fanuc()));
  };
  EXPECT_EQ(written("G0 X100. Y0. Z0.\n"), "G0 X99.960 Y0. Z0.\n");
  EXPECT_EQ(written("G51.1 X0.\nG0 X100. Y0. Z0.\n"), "G0 X100.040 Y0. Z0.\n");
  // at X50: 100 - 200 = -100
  EXPECT_EQ(written("G51.1 X50.\nG0 X200. Y0. Z0.\n"), "G0 X200.040 Y0. Z0.\n");
  EXPECT_EQ(written("G51.1 X0. Y0.\nG50.1 X0.\nG0 X100. Y0. Z0.\n"), "G0 X99.960 Y0. Z0.\n");
  EXPECT_EQ(written("G51.1 X0.\nG50.1 X0.\nG0 X100. Y0. Z0.\n"), "G0 X99.960 Y0. Z0.\n");
  EXPECT_EQ(written("G51.1 X0. Y0.\nG0 X100. Y0. Z0.\nG2 X110. Y0. I5. J0. F100.\nG0 X100.\n"),
            "G0 X100.040\n");
}

// SCALE and MIRROR of words, about the zero of the frame; ASCALE about that of a shift.
TEST(Scale, ByWordsOfEveryAxis) {
  const Machine machine = three_axes({{"EXX", poly(0, {0, 5e-4})}});
  RewriteJob job = plain_job();
  job.setup.profile = embedded_profile("siemens");
  const auto run_words = [&](const std::string& words) {
    return rewrite(machine, "G17 G90 G94 G710 G54 D0\n" + words + "M30\n", job);
  };
  EXPECT_EQ(last_but_end(run_words("SCALE X2 Y2 Z2\nG0 X100 Y0 Z0\n")), "G0 X99.9500 Y0 Z0\n");
  EXPECT_EQ(last_but_end(run_words("SCALE X4 Y2\nG0 X100 Y0 Z0\nG1 X50 F100\n")), "G1 X49.9750 F100\n");
  EXPECT_TRUE(run_words("SCALE X4 Y2\nG0 X100 Y0 Z0\nG2 X110 I5 J0 F100\n").has("E-FRAME"));
  EXPECT_EQ(last_but_end(run_words("TRANS X10\nASCALE X2\nG0 X100 Y0 Z0\n")), "G0 X99.9475 Y0 Z0\n");
  EXPECT_EQ(last_but_end(run_words("TRANS X10\nSCALE X2\nG0 X100 Y0 Z0\n")), "G0 X99.9500 Y0 Z0\n");
  EXPECT_EQ(last_but_end(run_words("SCALE X2\nTRANS X10\nG0 X100 Y0 Z0\n")), "G0 X99.9450 Y0 Z0\n");
  EXPECT_EQ(last_but_end(run_words("MIRROR X0\nG0 X100 Y0 Z0\n")), "G0 X99.9500 Y0 Z0\n");
  EXPECT_EQ(last_but_end(run_words("MIRROR X0\nMIRROR\nG0 X100 Y0 Z0\n")), "G0 X99.9500 Y0 Z0\n");
  // at X = 10 - 100 the machine is 0.045 short: 100 - 0.045
  EXPECT_EQ(last_but_end(run_words("TRANS X10\nAMIRROR X0\nG0 X100 Y0 Z0\n")), "G0 X99.9550 Y0 Z0\n");
  EXPECT_EQ(last_but_end(run_words("TRANS X10\nMIRROR X0\nG0 X100 Y0 Z0\n")), "G0 X99.9500 Y0 Z0\n");
  EXPECT_TRUE(run_words("SCALE X2\nAMIRROR X0\nG0 X100 Y0 Z0\n").has("E-ROTATION"));
  EXPECT_TRUE(run_words("MIRROR X5\nG0 X100 Y0 Z0\n").has("E-FRAME"));
  EXPECT_TRUE(run_words("MIRROR Z0\nG0 X100 Y0 Z0\n").has("E-FRAME"));
}

// In the first lines of a program they end nothing, and stand beside everything else.
TEST(Scale, EndsThatEndNothingStandAnywhere) {
  const Machine machine = three_axes({{"EXX", poly(0, {0, 5e-4})}});
  const std::string safe = "G0 G17 G21 G40 G49 G50 G80 G90 G94 G54\n";
  EXPECT_EQ(last_but_end(rewrite(machine, safe + "G50.1 X0. Y0.\nG0 X100. Y0. Z0.\nM30\n", fanuc())),
            "G0 X99.950 Y0. Z0.\n");
  const auto ends = rewrite(machine, safe + "G51 X0. Y0. Z0. P2.\nG0 X100. Y0. Z0.\nG0 G50\nM30\n", fanuc());
  EXPECT_TRUE(ends.has("E-BLOCK")) << ends.findings();
}

TEST(Mirror, NothingIsKnownUntilItIsCommanded) {
  const Machine machine = three_axes({{"EXX", poly(0, {0, 5e-4})}});
  const std::string moved = kStart + std::string("G0 X1. Y1. Z1.\n");
  EXPECT_TRUE(rewrite(machine, moved + "G51.1 X0.\nG1 X5. F100.\nM30\n", fanuc()).has("E-POS"));
  EXPECT_TRUE(rewrite(machine, moved + "G51 X0. Y0. Z0. P2.\nG1 X5. F100.\nM30\n", fanuc()).has("E-POS"));
  EXPECT_TRUE(rewrite(machine, moved + "G68 X0. Y0. R30.\nG51.1 X0.\nM30\n", fanuc()).has("E-FRAME"));
  EXPECT_TRUE(rewrite(machine, moved + "G51.1 X0.\nG68 X0. Y0. R30.\nM30\n", fanuc()).has("E-ROTATION"));
  EXPECT_TRUE(rewrite(machine, moved + "G51.1 X0.\nG52 X5.\nM30\n", fanuc()).has("E-ROTATION"));
}

}  // namespace
}  // namespace abbe::testing
