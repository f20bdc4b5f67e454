// Dialects as a user meets them: the verb profiles, a profile file, and programs that nobody here wrote.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/cli/run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kMachine = R"(format = 1
[machine]
name = "dialects"
chain = "w b X Y Z t"
[axis.X]
range = [-2000, 2000]
[axis.Y]
range = [-2000, 2000]
[axis.Z]
range = [-2000, 2000]
[errors]
EXX = { poly = [0, 0.02, 1e-5] }
EYX = { poly = [0, 0.01, 2e-5] }
EZY = { poly = [0, 0.005, -1e-5] }
EC0Y = 20
EB0Z = 15
)";

TEST(Profiles, AreListedAndExplained) {
  const auto all = run_abbe({"profiles"});
  EXPECT_EQ(all.exit, 0);
  for (const char* name : {"fanuc", "grbl", "grblhal", "haas", "heidenhain", "iso", "linuxcnc", "siemens"})
    EXPECT_THAT(all.out, HasSubstr(name));
  const auto fanuc = run_abbe({"profiles", "fanuc"});
  EXPECT_THAT(fanuc.out, AllOf(HasSubstr("G54.1"), HasSubstr("refused: a macro moves the machine"),
                               HasSubstr("every other code is refused")));
  const auto list = json::parse(run_abbe({"profiles", "--json"}).out);
  EXPECT_EQ(list.size(), 7U);
  const auto one = json::parse(run_abbe({"profiles", "haas", "--json"}).out);
  EXPECT_EQ(one["name"], "haas");
  EXPECT_EQ(one["integer_words"], "ask");
  EXPECT_EQ(one["decimals"]["mm"], 3);
  EXPECT_THAT(run_abbe({"profiles", "--meanings"}).out, HasSubstr("numbered-work-offset"));
}

TEST(Profiles, MistakesAreTold) {
  const Folder folder;
  const std::string file =
      folder.put("my.toml", "format = 1\nextends = \"fanuc\"\n[codes]\nM251 = \"copi\"\n");
  const auto wrong = run_abbe({"profiles", "--profile", file});
  EXPECT_EQ(wrong.exit, 2);
  EXPECT_THAT(wrong.err, HasSubstr("my.toml:4:8: error[E-VALUE]"));
  const auto unknown = run_abbe({"profiles", "fanuk"});
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_THAT(unknown.err, HasSubstr("did you mean 'fanuc'?"));
  EXPECT_EQ(run_abbe({"profiles", "--profile", folder / "none.toml"}).exit, 2);
  EXPECT_EQ(run_abbe({"profiles", "fanuc", "--profile", file}).exit, 2);
}

TEST(Profiles, AFileOfOnesOwnTeachesACode) {
  const Folder folder;
  folder.put("m.toml", kMachine);
  folder.put("p.nc", "G21 G90\nG0 X100. Y0. Z0.\nM251\nM30\n");
  folder.put("vmc.toml", "format = 1\nextends = \"fanuc\"\n[codes]\nM251 = \"auxiliary\"\n");
  const std::vector<std::string> base = {"compensate", "m.toml",   "p.nc",        "-o",
                                         "o.nc",       "--offset", "G54=X0,Y0,Z0"};
  auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), base.begin(), base.end());
    return run_abbe(more, {}, folder.path());
  };
  const auto refused = with({"--dialect", "fanuc"});
  EXPECT_EQ(refused.exit, 3);
  EXPECT_THAT(refused.err, HasSubstr("p.nc:3:1: error[E-MCODE]"));
  const auto done = with({"--profile", "vmc.toml"});
  EXPECT_EQ(done.exit, 0) << done.err;
}

/// Programs of other people that a dialect must accept: refusing is no way out.
struct Accepted {
  const char* dialect;
  const char* file;
  std::vector<std::string> options;
};

class MustAccept : public ::testing::TestWithParam<Accepted> {};

TEST_P(MustAccept, ProgramsOfOthers) {
  const std::string program = std::string(ABBE_SOURCE_DIR "/../shared/data/gcode/") + GetParam().file;
  if (!std::filesystem::exists(program)) GTEST_SKIP() << "no " << program;
  const Folder folder;
  const std::string machine = folder.put("m.toml", kMachine);
  std::string tools;
  for (int i = 1; i < 60; ++i) tools += "T" + std::to_string(i) + " P" + std::to_string(i) + " Z100 D10\n";
  std::vector<std::string> arguments = {
      "compensate",    machine,        program,     "-o",
      folder / "o.nc", "--json",       "--dialect", GetParam().dialect,
      "--offset",      "G54=X0,Y0,Z0", "--tools",   folder.put("tool.tbl", tools),
      "--start",       "X0,Y0,Z0"};
  arguments.insert(arguments.end(), GetParam().options.begin(), GetParam().options.end());
  const auto run = run_abbe(arguments);
  ASSERT_EQ(run.exit, 0) << run.err;
  const auto report = json::parse(run.out);
  EXPECT_LE(report["after"]["max_um"].get<double>(), 1 + report["quantisation_um"].get<double>());
}

const std::vector<std::string> kStated = {"--units", "mm", "--integer-words", "units"};

INSTANTIATE_TEST_SUITE_P(
    Corpus, MustAccept,
    ::testing::Values(
        Accepted{"fanuc", "maestro-G17_18_19.NC", kStated}, Accepted{"fanuc", "maestro-G81.NC", kStated},
        Accepted{"fanuc", "maestro-VINT_360arc.NC", kStated},
        Accepted{"haas", "maestro-G17_18_19.NC", kStated}, Accepted{"haas", "maestro-G81.NC", kStated},
        Accepted{"haas", "maestro-VINT_360arc.NC", kStated}, Accepted{"grbl", "camotics-slant_test.nc", {}},
        Accepted{"grbl", "cncjs-arc-xy-plane.gcode", {}}, Accepted{"grbl", "cncjs-arc-xz-plane.gcode", {}},
        Accepted{"grbl", "ugs-comments.gcode", {}}, Accepted{"grbl", "ugs-g17-g18-g19.gcode", {}},
        Accepted{"grblhal", "camotics-slant_test.nc", {}},
        Accepted{"grblhal", "cncjs-arc-xy-plane.gcode", {}}, Accepted{"grblhal", "ugs-g17-g18-g19.gcode", {}},
        Accepted{"linuxcnc", "ugs-arc_rword_test.gcode", {}},
        Accepted{"linuxcnc", "ugs-g17-g18-g19.gcode", {}}, Accepted{"linuxcnc", "tangent_helix.ngc", {}},
        Accepted{"linuxcnc", "camotics-slant_test.nc", {}}),
    [](const auto& test) {
      std::string name = std::string(test.param.dialect) + "_" + test.param.file;
      for (char& c : name)
        if (c == '-' || c == '.') c = '_';
      return name;
    });

/// Inputs on which other programs drop words, move a wrong frame or invent holes: right, or refused with a
/// place.
struct PeerInput {
  const char* name;
  const char* dialect;
  const char* program;
  int exit;
  const char* expected;  ///< a part of the output, or of the findings
};

class PeersFail : public ::testing::TestWithParam<PeerInput> {};

TEST_P(PeersFail, HereComesOutRightOrRefused) {
  const Folder folder;
  // Z rises with X: 0.5 um per mm; no other error
  folder.put("m.toml",
             "format = 1\n[machine]\nname = \"peers\"\nchain = \"w b X Y Z t\"\n[errors]\nEZX = { poly = [0, "
             "-0.5] }\n");
  folder.put("p.ngc", GetParam().program);
  const auto run = run_abbe(
      {"compensate", "m.toml", "p.ngc", "-o", "-", "--header", "none", "--datum", "ideal", "--offset",
       "G54=X0,Y0,Z0", "--dialect", GetParam().dialect, "--start", "X0,Y0,Z5", "--block-delete", "off"},
      {}, folder.path());
  EXPECT_EQ(run.exit, GetParam().exit) << run.err;
  EXPECT_THAT(run.exit == 0 ? run.out : run.err, HasSubstr(GetParam().expected)) << run.err;
}

INSTANTIATE_TEST_SUITE_P(
    Inputs, PeersFail,
    ::testing::Values(
        PeerInput{"machine_coordinates", "linuxcnc", "G0 X25\nG53 G0 Z0\nM2\n", 0, "\nG53 G0 Z0\n"},
        PeerInput{"increments", "linuxcnc", "G91\nG1 X25 F100\nM2\n", 0, "G91\nG1 X25 F100 Z0.0125\n"},
        PeerInput{"inverse_time", "linuxcnc", "G93 G1 X25 F2\nG94\nM2\n", 0, "G93 G1 X25 F2 Z5.0125\n"},
        PeerInput{"units_in_the_block", "linuxcnc", "G20 G90 G0 X1\nM2\n", 0, "G20 G90 G0 X1 Z0.19735\n"},
        PeerInput{"further_axes", "linuxcnc", "G1 X30 A90 F50\nM2\n", 3, "p.ngc:1:8: error[E-ROTARY]"},
        PeerInput{"extruder", "linuxcnc", "G1 X30 E5 F50\nM2\n", 3, "p.ngc:1:8: error[E-WORD]"},
        PeerInput{"block_delete", "linuxcnc", "/G1X25F10\nM2\n", 0, "/G1X25F10Z5.0125\n"},
        PeerInput{"number_and_comment", "linuxcnc", "N10 G1X25F10 (move)\nM2\n", 0,
                  "N10 G1X25F10 Z5.0125 (move)\n"},
        PeerInput{"position_set", "linuxcnc", "G92X100\nG1X105F10\nM2\n", 0, "G1X105F10Z5.0025\n"},
        PeerInput{"arc_by_centre", "grbl", "G2X20Y0I10J0F100\nM2\n", 0, "G2"},
        PeerInput{"holes", "linuxcnc", "G99 G81 X5 Y5 Z-2 R1 F50\nX9\nG80\nM2\n", 0, "\nX9"},
        PeerInput{"frame_and_rapid", "linuxcnc", "G54 G0 X50\nG1 X55 F50\nM2\n", 0,
                  "G54 G0 X50 Z5.0250\nG1 X55 F50 Z5.0275\n"},
        PeerInput{"signs", "linuxcnc", "G0 X+1.0\nM2\n", 0, "G0 X+1.0 Z5.0005\n"},
        PeerInput{"variables", "linuxcnc", "#100=5\nX#100\nM2\n", 3, "p.ngc:2:2: error[E-EXPR]"},
        PeerInput{"digits", "linuxcnc", "G0 X1.234567\nM2\n", 0, "X1.234567"},
        PeerInput{"tool_centre_point", "linuxcnc", "G43.4 H1\nM2\n", 3, "error[E-TCP]"},
        PeerInput{"cycle_without_cycles", "grbl", "G81 X5 Z-2 R1 F50\nX9\nM2\n", 3, "error[E-CYCLE]"},
        PeerInput{"rotation", "linuxcnc", "G68 X0 Y0 R45\nM2\n", 3, "p.ngc:1:1: error[E-FRAME]"},
        PeerInput{"shear", "linuxcnc", "G1 X10 F50\nG1 Y100\nM2\n", 0, "G1 X10 F50 Z5.0050\nG1 Y100\n"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace abbe::cli
