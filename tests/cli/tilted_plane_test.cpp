// Programs on tilted planes as post-processors write them: none of them may be refused.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/cli/run_program.h"

namespace abbe::cli {
namespace {

constexpr const char* kTable = R"(format = 1
[machine]
name = "table table"
chain = "w C A X b Y Z t"
[axis.X]
errors_seen = "body"
[axis.Y]
[axis.Z]
[axis.A]
direction = [-1, 0, 0]
origin = [0, 0, -120]
range = [-30, 120]
[axis.C]
direction = [0, 0, -1]
[control]
mode = "axis"
tilt_solution = "A+"
[control.axis.C]
turning = "shortest"
[errors]
EYX = { poly = [0, 0.2, 1e-4] }
EXX = { poly = [0, 0.1] }
EA0Z = 40
EB0A = 30
)";

constexpr const char* kHead = R"(format = 1
[machine]
name = "fork head"
chain = "w b X Y Z C A t"
[axis.X]
[axis.Y]
[axis.Z]
[axis.A]
direction = [1, 0, 0]
range = [-100, 100]
[axis.C]
direction = [0, 0, 1]
[control]
mode = "axis"
[errors]
EYX = { poly = [0, 0.2, 1e-4] }
EXZ = { poly = [0, 0.1] }
EB0A = 30
)";

// The table of the first machine turns the other way round than the head of the second: both stand at A30
// C90.
constexpr const char* kFanuc = R"(%
O0100 (3+2)
G21 G17 G40 G49 G80 G90 G94 G54
T1 M6
G91 G28 Z0.
G90
G0 A30. C90.
G68.2 X50. Y20. Z-10. I90. J30. K0.
G53.1
S6000 M3
G0 X0. Y0.
G43 H1 Z50.
M8
G1 Z-2. F300.
X60.5 F1200.
G3 X70.5 Y10. I0. J10.
G1 Y40.
G0 Z10.
G98 G81 X20. Y20. Z-12. R2. F200.
X40.
G80
G0 Z50.
G69
G91 G28 Z0.
G90 G0 A0. C0.
M30
%
)";

constexpr const char* kSiemens = R"(N10 G17 G40 G60 G90 G94 G710
N20 T="MILL_D10"
N30 M6
N40 D1 S6000 M3
N50 G54
N60 SUPA G0 Z0 D0
N70 D1
N80 CYCLE800(0,"TABLE",0,57,50,20,-10,30,0,0,,,,0)
N90 G0 A30 C0
N100 G0 X0 Y0 Z50
N110 G1 Z-2 F300
N120 X60.5 F1200
N130 G3 X70.5 Y10 I0 J10
N140 G1 Y40
N150 G0 Z50
N160 CYCLE800()
N170 SUPA G0 Z0 D0
N180 G0 A0 C0
N190 M30
)";

constexpr const char* kSiemensTurned = R"(N10 G17 G40 G60 G90 G94 G710
N20 T="MILL_D10"
N30 M6
N40 D1 S6000 M3
N50 G54
N60 SUPA G0 Z0 D0
N70 D1
N80 CYCLE800(1,"TABLE",0,27,50,20,-10,90,0,30,0,0,0,1)
N100 G0 X0 Y0 Z50
N110 G1 Z-2 F300
N120 X60.5 F1200
N130 G0 Z50
N140 CYCLE800(1,"TABLE",0,57,0,0,0,-40,0,0,0,0,0,1)
N150 G0 X0 Y0 Z50
N160 G1 X30 F300
N170 CYCLE800()
N190 M30
)";

constexpr const char* kHeidenhain = R"(0 BEGIN PGM 32 MM
1 TOOL CALL 1 Z S6000
2 L Z-1 R0 FMAX M91
3 PLANE SPATIAL SPA+30 SPB+0 SPC+90 STAY
4 L A+30 C+90 R0 FMAX
5 L X+0 Y+0 Z+50 R0 FMAX M3
6 L Z-2 F300
7 L X+60 Y+5
8 CC X+60 Y+15
9 C X+70 Y+15 DR+
10 L Z+50 FMAX
11 PLANE RESET STAY
12 L Z-1 R0 FMAX M91
13 PLANE SPATIAL SPA-20 SPB+10 SPC+0 TURN FMAX SEQ+ COORD ROT
14 L X+0 Y+0 Z+50 R0 FMAX
15 L Z-2 F300
16 L X+60 Y+5
17 PLANE RESET TURN FMAX
18 L Z-1 R0 FMAX M91
19 M30
20 END PGM 32 MM
)";

std::string without_turns(std::string program) {
  program.erase(program.find("13 PLANE"), program.find("18 L Z-1") - program.find("13 PLANE"));
  return program;
}

struct Written {
  const char *name, *dialect, *machine;
  std::string program;
};

class TiltedPlanes : public ::testing::TestWithParam<Written> {};

TEST_P(TiltedPlanes, AreCompensated) {
  const Folder folder;
  folder.put("tool.tbl", "T1 P1 Z100 D10 ;name=\"MILL_D10\"\n");
  folder.put("m.toml", GetParam().machine);
  folder.put("part.nc", GetParam().program);
  const auto run = run_abbe({"compensate", "m.toml", "part.nc", "-o", "out.nc", "--json", "--dialect",
                             GetParam().dialect, "--offset", "G54=X10,Y-20,Z5", "--tools", "tool.tbl"},
                            {}, folder.path());
  ASSERT_EQ(run.exit, 0) << run.err;
  const auto report = nlohmann::json::parse(run.out);
  EXPECT_GE(report["before"]["max_um"].get<double>(), 5);
  EXPECT_LE(report["after"]["max_um"].get<double>(), 1 + report["quantisation_um"].get<double>());
}

INSTANTIATE_TEST_SUITE_P(Controls, TiltedPlanes,
                         ::testing::Values(Written{"fanuc", "fanuc", kTable, kFanuc},
                                           Written{"fanuc_head", "fanuc", kHead, kFanuc},
                                           Written{"siemens", "siemens", kTable, kSiemens},
                                           Written{"siemens_head", "siemens", kHead, kSiemens},
                                           Written{"siemens_turned", "siemens", kTable, kSiemensTurned},
                                           Written{"heidenhain", "heidenhain", kTable, kHeidenhain},
                                           Written{"heidenhain_head", "heidenhain", kHead,
                                                   without_turns(kHeidenhain)}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace abbe::cli
