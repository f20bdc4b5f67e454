// Each hazard as a user meets it: abbe compensate MACHINE PROGRAM, its exit code, and either the output, byte
// by byte, or the refusal with its code and place. What the expected outputs mean is said by the machine
// files.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "tests/cli/run_program.h"

namespace abbe::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

struct Hazard {
  const char* name;
  const char* machine;
  int exit;
  std::vector<std::string> findings;  ///< "line:column: error[CODE]"; all of them
  std::vector<std::string> options;
};

struct Outcome {
  ProgramRun run;
  std::string output;
  bool written = false;
};

Outcome compensate(const std::string& name, const std::string& machine,
                   const std::vector<std::string>& options) {
  const Folder folder;
  const std::string out = folder / "out.ngc";
  std::vector<std::string> arguments = {"compensate", machine + ".toml", name + ".ngc", "-o",
                                        out,          "--header",        "none",        "--datum",
                                        "ideal",      "--offset",        "G54=X0,Y0,Z0"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  Outcome outcome;
  outcome.run = run_abbe(arguments, {}, ABBE_HAZARDS);
  outcome.written = std::filesystem::exists(out);
  if (outcome.written) outcome.output = content(out);
  return outcome;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

class Hazards : public ::testing::TestWithParam<Hazard> {};

TEST_P(Hazards, AreMet) {
  const Hazard& hazard = GetParam();
  const Outcome outcome = compensate(hazard.name, hazard.machine, hazard.options);
  EXPECT_EQ(outcome.run.exit, hazard.exit) << outcome.run.err;
  EXPECT_EQ(outcome.written, hazard.exit == 0);
  if (hazard.exit == 0) {
    EXPECT_EQ(outcome.output, content(std::string(ABBE_HAZARDS) + "/" + hazard.name + ".expected.ngc"));
  }
  for (const std::string& finding : hazard.findings)
    EXPECT_THAT(outcome.run.err, HasSubstr(std::string(hazard.name) + ".ngc:" + finding));
  EXPECT_EQ(count(outcome.run.err, ": error["), hazard.findings.size()) << outcome.run.err;
}

INSTANTIATE_TEST_SUITE_P(
    Programs, Hazards,
    ::testing::Values(
        Hazard{"h01_machine_coordinates", "offset", 0, {}, {}}, Hazard{"h02_increments", "scale", 0, {}, {}},
        Hazard{"h03_modal_words", "kink", 0, {}, {}}, Hazard{"h04_inverse_time", "kink", 0, {}, {}},
        Hazard{"h05_further_axes", "kink", 3, {"4:9: error[E-ROTARY]", "5:7: error[E-WORD]"}, {}},
        Hazard{"h05_rotary_words", "kink_a", 0, {}, {}},
        Hazard{"h06_rotary_feed", "offset", 3, {"4:4: error[E-ROTARY]"}, {}},
        Hazard{"h06_rotary_alone", "askew_a", 0, {}, {}},
        Hazard{"h07_sign_is_direction", "sign_c", 0, {}, {}},
        Hazard{"h08_half_turn", "shortest_c", 3, {"4:1: error[E-TURN]"}, {}},
        Hazard{"h09_tiny_arc", "scale", 0, {}, {}}, Hazard{"h10_full_circle", "scale", 0, {}, {}},
        Hazard{"h11_radius_form", "scale", 0, {}, {}}, Hazard{"h12_other_planes", "offset", 0, {}, {}},
        Hazard{"h13_block_delete", "kink", 0, {}, {"--block-delete", "off"}},
        Hazard{"h14_block_numbers", "kink", 0, {}, {}}, Hazard{"h15_position_set", "offset", 0, {}, {}},
        Hazard{"h16_canned_cycles", "offset", 0, {}, {}},
        Hazard{"h17_variables",
               "offset",
               3,
               {"4:5: error[E-EXPR]", "5:1: error[E-EXPR]", "6:5: error[E-EXPR]"},
               {}},
        Hazard{"h18_unknown_codes", "offset", 3, {"4:1: error[E-FRAME]", "5:1: error[E-GCODE]"}, {}},
        Hazard{"h19_unknown_height", "offset", 0, {}, {"--tools", "tool.tbl"}},
        Hazard{"h20_integer_words",
               "offset",
               3,
               {"4:4: error[E-DECIMAL]", "5:4: error[E-DECIMAL]"},
               {"--dialect", "fanuc"}},
        Hazard{"h24_short_lines", "offset", 3, {"3:1: error[E-LINELEN]"}, {"--dialect", "grbl"}},
        Hazard{"h21_outside", "offset", 5, {"4:1: error[E-TRAVEL]"}, {}},
        Hazard{"h22_compensated", "offset", 3, {"1:2: error[E-COMPENSATED]"}, {}},
        Hazard{"h23_bytes", "offset", 0, {}, {}},
        Hazard{"h25_cutter_compensation", "kink", 0, {}, {"--radius", "D1=5"}},
        Hazard{"h25_short_corner",
               "offset",
               3,
               {"6:1: error[E-CUTCOM]", "7:1: error[E-CUTCOM]"},
               {"--radius", "D1=5"}},
        Hazard{"h25_unknown_radius", "kink", 3, {"4:1: error[E-CUTCOM]"}, {}},
        Hazard{"h26_stops_and_coolant", "kink", 0, {}, {}},
        Hazard{"h27_frame_of_the_block", "scale", 0, {}, {"--offset", "G55=X100,Y0,Z0"}},
        Hazard{"h28_checksum", "offset", 3, {"4:10: error[E-CHAR]"}, {}},
        Hazard{"h30_nurbs",
               "offset",
               3,
               {"4:1: error[E-GCODE]", "8:1: error[E-GCODE]"},  // not one for each of its points
               {}},
        Hazard{"h30_first_point", "scale", 0, {}, {"--dialect", "fanuc"}},
        Hazard{"h29_subprograms", "offset", 3, {"4:1: error[E-MCODE]", "6:1: error[E-MCODE]"}, {}},
        Hazard{"h29_called_once", "offset", 0, {}, {"--dialect", "fanuc"}},
        Hazard{"h29_called_twice", "offset", 3, {"7:1: error[E-OWORD]"}, {"--dialect", "fanuc"}},
        Hazard{"h31_modal_cycle", "slope", 0, {}, {"--dialect", "siemens"}},
        Hazard{"h31_fed_to_a_hole",
               "slope",
               3,
               {"5:1: error[E-CYCLE]", "6:1: error[E-CYCLE]", "8:1: error[E-BLOCK]"},
               {"--dialect", "siemens"}}),
    [](const auto& test) { return std::string(test.param.name); });

/// The number behind a letter in each block, or NaN.
std::vector<double> words(const std::string& program, char letter) {
  std::vector<double> values;
  std::istringstream lines(program);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line[0] == '(' ? std::string::npos : line.find(letter);
    values.push_back(at == std::string::npos ? NAN : std::stod(line.substr(at + 1)));
  }
  return values;
}

/// X100 is 100 mm or 0.1 mm: a factor of a thousand, which nothing in the program tells.
TEST(HazardLaws, IntegerWordsCountWhatTheFlagSays) {
  const Outcome increments =
      compensate("h20_integer_words", "offset", {"--dialect", "fanuc", "--integer-words", "increments"});
  EXPECT_THAT(increments.output, HasSubstr("G0 X99.990 Y0 Z0.020\nG1 X49.990 F500.\n")) << increments.run.err;
  const Outcome units =
      compensate("h20_integer_words", "offset", {"--dialect", "fanuc", "--integer-words", "units"});
  EXPECT_EQ(units.run.exit, 5) << "100 m are outside";
}

/// Codes of other controls that the programs of this folder meet, on each of them: handled or refused, never
/// moved.
TEST(HazardLaws, UnknownCodesAreRefusedOnEveryControl) {
  for (const char* dialect :
       {"linuxcnc", "fanuc", "haas", "grbl", "grblhal", "iso", "siemens", "heidenhain"}) {
    for (const char* name : {"h17_variables", "h18_unknown_codes", "h25_cutter_compensation", "h28_checksum",
                             "h29_subprograms", "h30_nurbs"}) {
      const Outcome outcome = compensate(name, "offset", {"--dialect", dialect});
      EXPECT_EQ(outcome.run.exit, 3) << dialect << " " << name;
      EXPECT_FALSE(outcome.written);
    }
  }
}

/// The output without regard to which of several right texts it is.
TEST(HazardLaws, IncrementsSumToTheAbsolutePlace) {
  const Outcome outcome = compensate("h02_increments", "scale", {});
  ASSERT_TRUE(outcome.written);
  double x = 0;
  for (const double step : words(outcome.output.substr(outcome.output.find("G91")), 'X'))
    x += std::isnan(step) ? 0 : step;
  EXPECT_NEAR(x, 99.5 / 1.00005, 0.51e-4);
}

TEST(HazardLaws, ATinyArcDoesNotEndOnItsStart) {
  const Outcome outcome = compensate("h09_tiny_arc", "scale", {});
  if (!outcome.written) return;  // refused is safe too
  const auto x = words(outcome.output, 'X');
  EXPECT_NE(x[2], x[3]) << outcome.output;
}

TEST(HazardLaws, AFullCircleInPiecesEndsWhereItStarts) {
  const Outcome outcome = compensate("h10_full_circle", "scale", {});
  ASSERT_TRUE(outcome.written);
  const auto x = words(outcome.output, 'X'), y = words(outcome.output, 'Y');
  ASSERT_GE(x.size(), 7U);
  EXPECT_EQ(x[2], x[x.size() - 3]) << outcome.output;
  EXPECT_EQ(y[2], y[y.size() - 3]) << outcome.output;
}

TEST(HazardLaws, NearlyHalfACircleIsNotWrittenWithR) {
  const Outcome outcome = compensate("h11_radius_form", "scale", {});
  ASSERT_TRUE(outcome.written);
  EXPECT_THAT(outcome.output.substr(outcome.output.find("G2 ")), Not(HasSubstr("R")));
}

TEST(HazardLaws, ArcsKeepPlaneAndSenseOnACrookedMachine) {
  const Outcome outcome = compensate("h12_other_planes", "scale", {});
  ASSERT_TRUE(outcome.written) << outcome.run.err;
  for (const char* code : {"G18 G2", "\nG3", "G19 G3", "G17 G3"})
    EXPECT_EQ(count(outcome.output, code), 1U) << code;
}

}  // namespace
}  // namespace abbe::cli
