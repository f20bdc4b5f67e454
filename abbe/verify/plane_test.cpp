// Tilted planes, scales and mirrors as the verifying reader sees them: places by hand, and wrong outputs.
#include "abbe/verify/plane.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <variant>

#include "abbe/chain/test_plan.h"
#include "abbe/core/test_files.h"
#include "abbe/core/units.h"
#include "abbe/machine/read_profile.h"
#include "abbe/verify/reader.h"
#include "abbe/verify/verify.h"

namespace abbe::verifying {
namespace {

using abbe::testing::plan_of;
using abbe::testing::TestFile;

constexpr double kRounding = 1e-9;

const std::string kTable = R"(
format = 1
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
)";

ControlSetup setup_for(const char* dialect) {
  ControlSetup setup;
  setup.profile = embedded_profile(dialect);
  setup.work_offsets[0] = WorkOffset{};
  setup.tools[1] = ToolEntry{1, 1, {0, 0, 100}, 100.0, 10, ""};
  return setup;
}

/// Where the last motion of a program ends: a point of the tip, mm. Nothing: refused; `code` says why.
std::optional<Vec3> end_of(const std::string& program, const char* dialect, std::string* code = nullptr,
                           const std::string& machine = kTable) {
  const Plan plan = plan_of(machine);
  const Rotary rotary(plan.machine());
  const TestFile file(program);
  ProgramReader::Options options;
  options.rotary = &rotary;
  auto opened = ProgramReader::open(file.path(), "p", setup_for(dialect), options);
  auto& reader = std::get<ProgramReader>(opened);
  std::optional<Vec3> end;
  for (;;) {
    switch (reader.next()) {
      case ProgramReader::Item::motion:
        if (reader.motion().end.known == kAllAxes) end = reader.motion().end.at;
        break;
      case ProgramReader::Item::event:
        break;
      case ProgramReader::Item::end:
        return end;
      case ProgramReader::Item::refused:
        if (code != nullptr) *code = reader.refusal().code;
        return std::nullopt;
    }
  }
}

std::string fanuc(const std::string& words) { return "G21 G90 G94 G17 G54\n" + words + "M30\n"; }
std::string klartext(const std::string& words) { return "0 BEGIN PGM P MM\n" + words + "99 END PGM P MM\n"; }

void expect_place(const std::optional<Vec3>& is, const Vec3& wanted) {
  ASSERT_TRUE(is) << "refused";
  EXPECT_LT((*is - wanted).norm(), 1e-6) << is->transpose() << " is not " << wanted.transpose();
}

// M = Rz(-90) Rx(30) Rz(90): x -> y -> (0, cos 30, 1/2) -> (cos 30, 0, 1/2), and the origin is added.
TEST(TiltedPlane, EulerAnglesTurnAboutZXZ) {
  const std::string plane = "G0 A-30. C90.\nG68.2 X1. Y2. Z3. I-90. J30. K90.\nG53.1\n";
  expect_place(end_of(fanuc(plane + "G0 X100. Y0. Z0.\n"), "fanuc"), {87.60254038, 2, 53});
  // y -> -x -> -x -> (0, 1, 0)
  expect_place(end_of(fanuc(plane + "G0 X0. Y100. Z0.\n"), "fanuc"), {1, 102, 3});
  // z -> z -> (0, -1/2, cos 30) -> (-1/2, 0, cos 30)
  expect_place(end_of(fanuc(plane + "G0 X0. Y0. Z100.\n"), "fanuc"), {-49, 2, 89.60254038});
}

// M = Rz(90) Ry(0) Rx(30) about the fixed axes: y -> (0, cos 30, 1/2) -> (-cos 30, 0, 1/2).
TEST(TiltedPlane, SpatialAnglesTurnAboutFixedAxes) {
  // its normal is (1/2, 0, cos 30): A-30 C-90
  const std::string plane = "1 PLANE SPATIAL SPA+30 SPB+0 SPC+90 STAY\n2 L A-30 C-90 R0 FMAX\n";
  expect_place(end_of(klartext(plane + "3 L X+0 Y+100 Z+0 R0 FMAX\n"), "heidenhain"), {-86.60254038, 0, 50});
  expect_place(end_of(klartext(plane + "3 L X+100 Y+0 Z+0 R0 FMAX\n"), "heidenhain"), {0, 100, 0});
  // about X by 10, then Y by 20: x -> x -> (cos 20, 0, -sin 20)
  std::string code;
  const std::string other = "1 PLANE SPATIAL SPA+0 SPB+20 SPC+0 TURN SEQ- FMAX\n3 L X+100 Y+0 Z+0 R0 FMAX\n";
  expect_place(end_of(klartext(other), "heidenhain", &code,
                      kTable + "tilt_solution = \"A-\"\n[control.axis.C]\nturning = \"shortest\"\n"),
               {93.96926208, 0, -34.20201433});
  EXPECT_EQ(code, "");
  // without SEQ this control takes the nearer way, whatever the machine file says of others
  const std::string nearer = "1 PLANE SPATIAL SPA+0 SPB+20 SPC+0 TURN FMAX\n3 L X+100 Y+0 Z+0 R0 FMAX\n";
  EXPECT_FALSE(end_of(klartext(nearer), "heidenhain", &code,
                      kTable + "tilt_solution = \"A-\"\n[control.axis.C]\nturning = \"shortest\"\n"));
  EXPECT_EQ(code, "E-PLANE");
}

// MODE 27: about Z, then the new Y, then the new X; the plane's own shift is along its axes.
TEST(TiltedPlane, SwivelsAxisByAxis) {
  const auto siemens = [](const std::string& words) { return "G17 G90 G94 G710 G54 D0\n" + words + "M30\n"; };
  const std::string plane = "CYCLE800(0,\"T\",0,27,1,2,3,-90,0,30,0,40,0,0)\nG0 A-30 C90\n";
  // Rz(-90) Rx(30): y -> (0, cos 30, 1/2) -> (cos 30, 0, 1/2)
  expect_place(end_of(siemens(plane + "G0 X0 Y100 Z0\n"), "siemens"), {1 + 140 * 0.8660254038, 2, 73});
  expect_place(end_of(siemens(plane + "G0 X100 Y-40 Z0\n"), "siemens"), {1, -98, 3});
  expect_place(end_of(siemens("TRANS X10\nASCALE X2 Z3\nG0 X100 Y5 Z1\n"), "siemens"), {210, 5, 3});
  expect_place(end_of(siemens("SCALE X2\nTRANS X10\nG0 X100 Y5 Z1\n"), "siemens"), {110, 5, 1});
  expect_place(end_of(siemens("MIRROR Y0\nG0 X100 Y5 Z1\n"), "siemens"), {100, -5, 1});
  expect_place(end_of(siemens("TRANS X10\nAMIRROR X0\nG0 X100 Y5 Z1\n"), "siemens"), {-90, 5, 1});
  expect_place(end_of(siemens("TRANS X10\nMIRROR X0\nG0 X100 Y5 Z1\n"), "siemens"), {-100, 5, 1});
  std::string code;
  EXPECT_FALSE(end_of(siemens("CYCLE800(0,\"T\",0,57,1,2,3,-90,0,30,0,40,0,0)\nG0 A-30 C90\nG0 X0 Y0 Z0\n"),
                      "siemens", &code));
  EXPECT_EQ(code, "E-PLANE");
}

TEST(TiltedPlane, TheToolMustStandOnIt) {
  std::string code;
  const std::string plane = "G68.2 X0. Y0. Z0. I0. J30. K0.\n";
  for (const std::string& before : {"G0 A-28. C0.\n" + plane + "G53.1\n", "G0 A30. C0.\n" + plane + "G53.1\n",
                                    "G0 A-30. C0.\n" + plane, std::string("G0 A-30. C0.\nG53.1\n")}) {
    EXPECT_FALSE(end_of(fanuc(before + "G0 X0. Y0. Z0.\n"), "fanuc", &code)) << before;
    EXPECT_EQ(code, "E-PLANE") << before;
  }
  EXPECT_FALSE(end_of(klartext("1 PLANE SPATIAL SPA+30 SPB+0 SPC+0 STAY\n2 L A-29 C+0 R0 FMAX\n"
                               "3 L X+0 Y+0 Z+0 R0 FMAX\n"),
                      "heidenhain", &code));
  EXPECT_EQ(code, "E-PLANE");
}

TEST(TiltedPlane, ToolsAreLaidAlongANormal) {
  const Plan plan = plan_of(kTable);
  const Rotary rotary(plan.machine());
  // d = Rz(-c) Rx(-a) z = (-sin c sin a', ..): at A-30 C90 (-1/2, 0, cos 30)
  const Vec3 normal(-0.5, 0, std::cos(30 * deg));
  EXPECT_LT(askew(rotary, normal, {-30 * deg, 0, 90 * deg}), kRounding);
  EXPECT_NEAR(askew(rotary, normal, {-30 * deg, 0, -90 * deg}), 60 * deg, kRounding);
  const auto laid = laid_along(rotary, normal, {-29 * deg, 0, 91 * deg});
  ASSERT_TRUE(laid);
  EXPECT_NEAR((*laid)[0], -30 * deg, kRounding);
  EXPECT_NEAR((*laid)[2], 90 * deg, kRounding);
}

// 2 (x - 10) + 10, and (20 - x) on the other side.
TEST(Placements, ScaleAndMirrorCountFromTheirCentres) {
  expect_place(end_of(fanuc("G51 X10. Y0. Z5. P2.\nG0 X100. Y7. Z5.\n"), "fanuc"), {190, 14, 5});
  expect_place(end_of(fanuc("G51.1 X10.\nG0 X100. Y7. Z5.\n"), "fanuc"), {-80, 7, 5});
  expect_place(end_of(fanuc("G51.1 X10. Y1.\nG50.1 X0.\nG0 X100. Y7. Z5.\n"), "fanuc"), {100, -5, 5});
  expect_place(end_of(fanuc("G51 X10. Y0. Z5. P2.\nG50\nG0 X100. Y7. Z5.\n"), "fanuc"), {100, 7, 5});
  expect_place(end_of(fanuc("G0 G40 G49 G50 G80\nG50.1 X1. Y2.\nG0 X100. Y7. Z5.\n"), "fanuc"), {100, 7, 5});
  EXPECT_FALSE(end_of(fanuc("G51 X10. Y0. Z5. P2.\nG0 X1. Y1. Z1.\nG0 G50\n"), "fanuc", nullptr));
}

VerifyReport judge(const std::string& original, const std::string& output) {
  const TestFile a(original), b(output);
  VerifyJob job;
  job.original_path = a.path();
  job.output_path = b.path();
  job.original_name = "original";
  job.output_name = "output";
  job.setup = setup_for("fanuc");
  return verify_program(plan_of(kTable), job);
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

struct Wrong {
  const char *from, *to;
};
class WrongOutputs : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongOutputs, AreFound) {
  const std::string program = fanuc(
      "G0 A-30. C90.\nG68.2 X1. Y2. Z3. I-90. J30. K90.\nG53.1\nG0 X0. Y0. Z20.\nG1 X30. Y5. F500.\n"
      "G2 X40. I5. J0.\nG98 G81 X12. Y3. Z-3. R2.\nG80\nG69\nG51 X0. Y0. Z0. P2.\nG0 X0. Y0. Z30.\n"
      "G1 X31. F500.\nG3 X41. I5. J0.\nG50\nG51.1 X7.\nG0 X0. Y1. Z25.\nG1 X32.\nG2 X42. I5. J0.\n"
      "G50.1 X0.\n");
  EXPECT_TRUE(judge(program, program).agrees);
  EXPECT_FALSE(judge(program, changed(program, GetParam().from, GetParam().to)).agrees)
      << GetParam().from << " " << GetParam().to;
}

INSTANTIATE_TEST_SUITE_P(Frames, WrongOutputs,
                         ::testing::Values(Wrong{"I-90.", "I90."}, Wrong{"K90.", "K89.9"},
                                           Wrong{"Z3.", "Z3.01"}, Wrong{"G53.1\n", ""},
                                           Wrong{"X30. Y5.", "X30. Y5.004"},
                                           Wrong{"X30. Y5.", "X30. Y5. Z20.004"},
                                           Wrong{"I5. J0.", "I5. J0.1"}, Wrong{"X12.", "X12.004"},
                                           Wrong{"G69\n", ""}, Wrong{"P2.", "P2.001"},
                                           Wrong{"X31.", "X31. Y0.004"}, Wrong{"G3 X41.", "G2 X41."},
                                           Wrong{"G51.1 X7.", "G51.1 X7.01"}, Wrong{"X32.", "X32. Z25.004"},
                                           Wrong{"G2 X42.", "G3 X42."}, Wrong{"G50.1 X0.", "G50.1 Y0."}));

}  // namespace
}  // namespace abbe::verifying
