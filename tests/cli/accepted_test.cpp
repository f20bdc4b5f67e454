// Programs as post-processors write them for controls of which few are public: none of them may be refused.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/cli/run_program.h"

namespace abbe::cli {
namespace {

constexpr const char* kThreeAxes = R"(format = 1
[machine]
name = "mill"
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
[errors]
EXX = { poly = [0, 0.2, 1e-5] }
EYX = { poly = [0, 0.1, 2e-5] }
EC0Y = 20
)";

constexpr const char* kGentle = R"(format = 1
[machine]
name = "mill"
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
[errors]
EXX = { poly = [0, 0.06, 1e-5] }
EYX = { poly = [0, 0.05, 2e-5] }
EC0Y = 20
)";

constexpr const char* kTiltingTable = R"(format = 1
[machine]
name = "table table"
chain = "w C A X b Y Z t"
[axis.X]
errors_seen = "body"
[axis.Y]
[axis.Z]
[axis.A]
direction = [-1, 0, 0]
[axis.C]
direction = [0, 0, -1]
[control]
mode = "tcp"
codes = { "G43.5" = "tcp-vectors", G49 = "axis" }
vectors = { turns = "nearest", between = "axes" }
[errors]
EYX = { poly = [0, 0.02, 1e-5] }
EA0Z = 20
)";

constexpr const char* kSiemens = R"(%_N_POCKET_MPF
;$PATH=/_N_WKS_DIR/_N_PART_WPD
N10 G17 G40 G60 G90 G94 G710
N20 MSG("roughing, end mill 10 mm")
N30 T="MILL_D10"
N40 M6
N50 D1 S6000 M3
N60 G54
N70 G0 X-20 Y-15
N80 G0 Z50
N90 Z2 M8
N100 G1 Z-3.5 F300
N110 X120.25 F1200
N120 G3 X130.25 Y-5 I0 J10
N130 G1 Y60
N140 G2 X120.25 Y70 CR=10
N150 G1 X-10 Y72.125 Z-3.8
N160 G64
N170 TRANS X150 Y20
N180 G0 X0 Y0
N190 G1 X30 Y12.5
N200 AROT Z15
N205 G0 X45 Y0
N210 G1 Z-3
N220 G3 X45 Y0 I-15 J0
N230 ROT
N240 TRANS
N245 G0 X0 Y0
N250 G1 Z-1
N260 G91 X2.5 Y-1
N270 G90 G0 Z50 M9
N271 F180
N272 MCALL CYCLE83(50,-1,2,-18,,-4,,0,,0,1,0,,3,0.5,0,0,0,0,1001110)
N273 X20 Y10
N274 X100 Y10
N275 Y50
N276 MCALL
N277 G0 X20 Y50
N278 CYCLE81(50,-1,2,-6)
N280 MSG()
N290 M5
N300 SUPA G0 Z0 D0
N310 M30
)";

constexpr const char* kSiemensFiveAxes = R"(N10 G17 G40 G90 G94 G710
N20 T="BALL_D8" M6
N30 D1 S12000 M3
N40 G54
N50 G0 A0 C0
N60 TRAORI
N62 ORIMKS
N64 ORIAXES
N70 G0 X0 Y0 Z50
N80 G1 X0 Y0 Z0 F800
N90 G1 X10 Y2 Z-1 A-10 C20
N100 X20 Y3 Z-1.5 A-12.5 C24.25
N110 X30 Y3.5 Z-1.25 A-14 C30
N120 G0 Z50
N130 TRAFOOF
N140 M30
)";

constexpr const char* kIso = R"(%
O1234
N10 G17 G71 G90 G94
N20 G54
N30 T3 M6
N40 G0 X-20. Y-15. Z50. S6000 M3
N50 Z2. M8
N60 G1 Z-3.5 F300.
N70 X120.25 F1200.
N80 G3 X130.25 Y-5. I0 J10.
N90 G1 Y60.
N100 G2 X120.25 Y70. I-10. J0
(finishing)
N110 G1 X-10. Y72.125 Z-3.8
N120 G91 X2.5 Y-1.
N130 G90 G0 Z50. M9
N140 M5
N150 M30
%
)";

constexpr const char* kHeidenhain = R"(0 BEGIN PGM PLATE MM
1 BLK FORM 0.1 Z X+0 Y+0 Z-30
2 BLK FORM 0.2 X+200 Y+120 Z+0
3 TOOL CALL 3 Z S3200 F400
4 L Z+100 R0 FMAX M3
5 L X+10 Y+10 R0 FMAX M8
6 CYCL DEF 200 DRILLING ~
  Q200=+2     ;SET-UP CLEARANCE ~
  Q201=-18.5  ;DEPTH ~
  Q206=+150   ;FEED RATE FOR PLNGNG ~
  Q202=+5     ;PLUNGING DEPTH ~
  Q210=+0     ;DWELL TIME AT TOP ~
  Q203=+0     ;SURFACE COORDINATE ~
  Q204=+50    ;2ND SET-UP CLEARANCE ~
  Q211=+0.2   ;DWELL TIME AT DEPTH
7 CYCL CALL
8 L X+190 FMAX M99
9 L Y+110 FMAX M99
10 L X+10 FMAX M99
11 CYCL DEF 207 RIGID TAPPING NEW ~
  Q200=+5     ;SET-UP CLEARANCE ~
  Q201=-15    ;DEPTH OF THREAD ~
  Q239=+1.25  ;THREAD PITCH ~
  Q203=-2.5   ;SURFACE COORDINATE ~
  Q204=+50    ;2ND SET-UP CLEARANCE
12 L X+50 Y+50 FMAX M89
13 L X+70 FMAX
14 L X+90 FMAX M99
15 L Z+100 FMAX M9
16 M30
17 END PGM PLATE MM
)";

/// A profile milled under cutter compensation, with the words of each control.
std::string milled_profile(const std::string& head, const std::string& tail, const std::string& left,
                           const std::string& round) {
  return head + "G1 Z-4. F300.\nG1 " + left +
         " X0. Y-10. F800.\nY50.\nG2 X10. Y60. I10. J0.\nG1 X70.\nG2 X80. Y50. " + round +
         "10.\nG1 Y0.\nX-15.\nG40 X-40. Y-20.\nG0 Z50. M9\n" + tail;
}

const std::string kLinuxCncProfile =
    milled_profile("%\nG21 G90 G17 G40 G49 G54\nT1 M6\nS6000 M3\nG43 H1\nG0 X-30. Y-30. Z50.\nZ2.\n",
                   "M2\n%\n", "G41 D1", "R");
const std::string kLinuxCncDirect =
    milled_profile("G21 G90 G17 G54\nT1 M6 G43\nG0 X-30. Y-30. Z50.\n", "M2\n", "G41.1 D10.", "R");
const std::string kFanucProfile = milled_profile(
    "%\nO0100 (PROFILE D10 CLIMB)\nG21 G17 G40 G49 G80 G90\nT1 M6\nG54 G0 X-30. Y-30. S6000 M3\nG43 H1 Z50. "
    "M8\nZ2.\n",
    "G91 G28 Z0.\nM30\n%\n", "G41 D1", "R");
const std::string kSiemensProfile =
    milled_profile("G17 G40 G90 G94 G710\nT=\"MILL_D10\" M6\nD1 S6000 M3\nG54\nG0 X-30. Y-30. Z50.\nZ2.\n",
                   "SUPA G0 Z0 D0\nM30\n", "G41", "CR=");

// Directions of the tool as NX and others post them: all three components in every block that turns.
constexpr const char* kSiemensVectors = R"(; blade, finishing
G90 G94 G710 G17 G40
T="BALL_D8"
M6
G54 D1
S12000 M3
G0 A0 C0
TRAORI
G0 X0 Y0 Z50
G1 X0 Y0 Z0 A3=0 B3=0 C3=1 F800
X10 Y2 Z-1 A3=-0.059391175 B3=0.163175911 C3=0.984807753
X20 Y3 Z-1.5 A3=-0.088896 B3=0.197327 C3=0.976296
X30 Y3.5
X40 Y3.5 Z-1.25 A3=-0.12 B3=0.21 C3=0.97
G0 Z50
TRAFOOF
M30
)";

constexpr const char* kFanucVectors = R"(%
O0043
N10 G21 G90 G94 G17 G40 G80
N20 G54
N30 T2 M6
N40 G0 A0. C0.
N50 G43.5 H2 X0. Y0. Z50.
N60 G0 Z5. S9000 M3
N70 G1 X0. Y0. Z0. I0. J0. K1. F800.
N80 X10. Y2. Z-1. I-.059391 J.163176 K.984808
N90 X20. Y3. Z-1.5 I-.088896 J.197327 K.976296
N100 X30. Y3.5
N110 G0 Z50.
N120 G49
N130 M30
%
)";

struct Written {
  const char *name, *dialect, *machine;
  std::string program;
  const char* start;
  double before_um;  ///< at least
};

class PostedPrograms : public ::testing::TestWithParam<Written> {};

TEST_P(PostedPrograms, AreCompensated) {
  const Folder folder;
  folder.put("tool.tbl",
             "T1 P1 Z100 D10 ;name=\"MILL_D10\"\nT2 P2 Z120 D8 ;name=\"BALL_D8\"\nT3 P3 Z90 D12\n");
  folder.put("m.toml", GetParam().machine);
  folder.put("part.nc", GetParam().program);
  const auto run =
      run_abbe({"compensate", "m.toml", "part.nc", "-o", "out.nc", "--json", "--dialect", GetParam().dialect,
                "--offset", "G54=X0,Y0,Z0", "--tools", "tool.tbl", "--start", GetParam().start},
               {}, folder.path());
  ASSERT_EQ(run.exit, 0) << run.err;
  const auto report = nlohmann::json::parse(run.out);
  EXPECT_GE(report["before"]["max_um"].get<double>(), GetParam().before_um);
  EXPECT_LE(report["after"]["max_um"].get<double>(), 1 + report["quantisation_um"].get<double>());
}

INSTANTIATE_TEST_SUITE_P(
    Controls, PostedPrograms,
    ::testing::Values(
        Written{"siemens", "siemens", kThreeAxes, kSiemens, "X0,Y0,Z0", 10},
        Written{"siemens_traori", "siemens", kTiltingTable, kSiemensFiveAxes, "X0,Y0,Z0,A0,C0", 1},
        Written{"siemens_vectors", "siemens", kTiltingTable, kSiemensVectors, "X0,Y0,Z0,A0,C0", 1},
        Written{"fanuc_vectors", "fanuc", kTiltingTable, kFanucVectors, "X0,Y0,Z0,A0,C0", 1},
        Written{"heidenhain", "heidenhain", kThreeAxes, kHeidenhain, "X0,Y0,Z200", 10},
        Written{"iso", "iso", kThreeAxes, kIso, "X0,Y0,Z0", 10},
        Written{"linuxcnc_g41", "linuxcnc", kGentle, kLinuxCncProfile, "X0,Y0,Z0", 4},
        Written{"linuxcnc_g41_1", "linuxcnc", kGentle, kLinuxCncDirect, "X0,Y0,Z0", 4},
        Written{"fanuc_g41", "fanuc", kGentle, kFanucProfile, "X0,Y0,Z0", 4},
        Written{"haas_g41", "haas", kGentle, kFanucProfile, "X0,Y0,Z0", 4},
        Written{"siemens_g41", "siemens", kGentle, kSiemensProfile, "X0,Y0,Z0", 4}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace abbe::cli
