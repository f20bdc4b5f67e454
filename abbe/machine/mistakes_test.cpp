#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "abbe/machine/test_machines.h"

// Every mistake of a machine file with its place. In the texts, @ stands before the place that must be
// reported; it is removed before reading.

namespace abbe {
namespace {

using test::all_of;
using test::five_axis;
using test::read;

struct Mistake {
  std::string code;
  std::string text;
  std::string fix;  ///< part of the remedy; may be empty
};

std::string chain(const std::string& text) { return "format = 1\n[machine]\nchain = " + text + "\n"; }

std::vector<Mistake> mistakes() {
  const auto five = [](const std::string& more) { return five_axis(more); };
  const auto errors = [](const std::string& more) { return five_axis("[errors]\n" + more + "\n"); };
  return {
      // the file
      {"E-TOML", "format = 1\n[machine]\nname = @oops\n", ""},
      {"E-TOML", "format = 1\nformat = @1\n", ""},
      {"E-TOML", five("@[axis.X]\n"), ""},
      {"E-TOML", "[@=]\n", ""},
      {"E-TOML", "[[@[\n", ""},
      {"E-TOML", "@\xc3\x9c = 1\n", ""},
      {"E-FORMAT", "@[machine]\nchain = \"w b t\"\n", "format = 1"},
      {"E-FORMAT", "format = @2\n[machine]\nchain = \"w b t\"\n", ""},
      {"E-FORMAT", "format = @1.0\n[machine]\nchain = \"w b t\"\n", ""},
      {"E-MISSING-KEY", "@format = 1\n", "[machine]"},
      {"E-MISSING-KEY", "format = 1\n@[machine]\nname = \"m\"\n", "chain"},
      {"E-UNKNOWN-KEY", five("[@eror]\nEXX = 1\n"), ""},
      {"E-UNKNOWN-KEY", five("[@error]\nEXX = 1\n"), "'errors'"},
      {"E-UNKNOWN-KEY", "format = 1\n[machine]\n@nam = \"m\"\nchain = \"w b t\"\n", "'name'"},
      {"E-UNKNOWN-KEY", five("[units]\n@lenght = \"mm\"\n"), "'length'"},
      {"E-TYPE", "format = 1\nunits = @3\n[machine]\nchain = \"w b t\"\n", ""},
      {"E-TYPE", "format = 1\n[machine]\nname = @3\nchain = \"w b t\"\n", ""},
      {"E-VALUE", five("[units]\nlength = @\"cm\"\n"), ""},
      {"E-VALUE", five("[units]\nangle = @\"degree\"\n"), ""},
      // the chain
      {"E-TYPE", chain("@[\"w\", \"b\", \"t\"]"), ""},
      {"E-CHAIN-ENDS", chain("\"@X b Z t\""), ""},
      {"E-CHAIN-ENDS", chain("\"w X b @Z\""), ""},
      {"E-CHAIN-ENDS", chain("@\"\""), ""},
      {"E-CHAIN-ENDS", chain("\"w X b @t Z t\""), ""},
      {"E-CHAIN-BED", chain("@\"w X Z t\""), ""},
      {"E-CHAIN-BED", chain("\"w X b Y @b Z t\""), ""},
      {"E-CHAIN-ELEMENT", chain("\"w X b @z t\""), "'Z'"},
      {"E-CHAIN-ELEMENT", chain("\"w X b @XY t\""), ""},
      {"E-CHAIN-ELEMENT", chain("\"w X b @1X t\""), ""},
      {"E-CHAIN-ELEMENT", chain("\"w X b @Z'' t\""), ""},
      {"E-CHAIN-DUPLICATE", chain("\"w X b Y @X t\""), ""},
      {"E-CHAIN-DUPLICATE", chain("\"w X b Y @X' t\""), ""},
      {"E-TOO-MANY-AXES", chain("\"w b X X1 X2 X3 X4 X5 X6 X7 X8 Y Y1 Y2 Y3 Y4 Y5 Y6 @Y7 t\""), "fixed"},
      // axes
      {"E-AXIS-UNKNOWN", five("[axis.@B]\ndirection = [0, 1, 0]\n"), ""},
      {"E-AXIS-UNKNOWN", five("[axis.@t]\norigin = [0, 1, 0]\n"), "[tool]"},
      {"E-AXIS-UNKNOWN", five("[axis.@a]\norigin = [0, 1, 0]\n"), "'A'"},
      {"E-TYPE", five("[axis]\nY = @3\n"), ""},
      {"E-UNKNOWN-KEY", five("[axis.Y]\n@orgin = [0, 1, 0]\n"), "'origin'"},
      {"E-AXIS-TYPE", chain("\"w b @Q t\""), "type"},
      {"E-AXIS-TYPE", chain("\"w b Q t\"") + "[axis.@Q]\ndirection = [1, 0, 0]\n", "type"},
      {"E-VALUE", five("[axis.Y]\ntype = @\"lineal\"\n"), "'linear'"},
      {"E-DIRECTION-NEEDED", chain("\"w b Q t\"") + "[axis.@Q]\ntype = \"linear\"\n", "direction"},
      {"E-DIRECTION-NEEDED", chain("\"w @B b t\""), "direction"},
      {"E-DIRECTION-NEEDED", five("[axis.@Y]\ntype = \"rotary\"\n"), "direction"},
      {"E-ZERO-VECTOR", five("[axis.Y]\ndirection = @[0, 0, 0]\n"), ""},
      {"E-COUNT", five("[axis.Y]\ndirection = @[0, 1]\n"), "3"},
      {"E-TYPE", five("[axis.Y]\norigin = [0, @\"1\", 0]\n"), "quotes"},
      {"E-NOT-FINITE", five("[axis.Y]\norigin = [0, @nan, 0]\n"), ""},
      {"E-NOT-FINITE", five("[axis.Y]\norigin = [0, @-inf, 0]\n"), ""},
      {"E-NOT-FINITE", five("[units]\nlength = \"m\"\n[axis.Y]\norigin = [0, 0, @1e307]\n"), "units"},
      {"E-INTERVAL", five("[axis.Y]\nrange = @[100, -100]\n"), ""},
      {"E-INTERVAL", five("[axis.Y]\nrange = @[100, 100]\n"), ""},
      {"E-ORDER-AND-LOCATION", five("[axis.Y]\nlocation = \"line\"\n@order = [\"motion\"]\n"), ""},
      {"E-ORDER-AND-LOCATION", five("[axis.Y]\norder = [\"motion\"]\n@location = \"line\"\n"), ""},
      {"E-VALUE", five("[axis.Y]\nlocation = @\"lines\"\n"), "'line'"},
      {"E-ORDER", five("[axis.Y]\norder = @[\"static\"]\n"), "motion"},
      {"E-ORDER", five("[axis.Y]\norder = [\"motion\", @\"component\"]\n"), ""},
      {"E-ORDER", five("[axis.Y]\norder = [\"motion\", @\"statc\"]\n"), "'static'"},
      {"E-ORDER", five("[axis.Y]\norder = [@\"-motion\"]\n"), "'motion'"},
      {"E-ORDER", five("[axis.Y]\norder = [\"motion\", @\"motion\"]\n"), ""},
      {"E-ORDER", five("[axis.Y]\norder = [\"-location\", \"motion\", @\"-location\"]\n"), ""},
      {"E-ORDER", five("[axis.S]\norder = [@\"motion\", \"static\"]\n"), ""},
      {"E-ORDER", five("[axis.S]\norder = [@\"across\", \"static\"]\n"), "location"},
      {"E-TYPE", five("[axis.Y]\norder = [\"motion\", @3]\n"), ""},
      {"E-FIXED-BODY", five("[axis.S]\nlocation = @\"line\"\n"), "frame"},
      {"E-FIXED-BODY", five("[axis.S]\n@range = [0, 1]\n"), ""},
      {"E-FIXED-BODY", five("[axis.S]\n@address = \"S\"\n"), ""},
      {"E-FIXED-BODY", five("[axis.S]\n@correctable = true\n"), ""},
      {"E-VALUE", five("[axis.Y]\nerrors_seen = @\"table\"\n"), ""},
      {"E-ERRORS-SEEN", five("[axis.Y]\nerrors_seen = @\"tool\"\n"), ""},
      {"E-ERRORS-SEEN", chain("\"w @X b Y t\"") + "[errors]\nEXX = 1\n", "errors_seen"},
      {"E-ERRORS-SEEN", chain("\"w X b Y t\"") + "[axis.@X]\norigin = [0, 0, 0]\n[errors]\nTXX = 1\n", ""},
      {"E-ERRORS-SEEN", chain("\"w @S b Y t\"") + "[errors]\nDXS = 1\n", "errors_seen"},
      {"E-ADDRESS", five("[axis.Y]\naddress = @\"y\"\n"), ""},
      {"E-ADDRESS", five("[axis.Y]\naddress = @\"\"\n"), ""},
      {"E-ADDRESS", five("[axis.@Y]\naddress = \"X\"\n"), ""},
      {"E-TYPE", five("[axis.Y]\ncorrectable = @\"no\"\n"), ""},
      // tool, workpiece, calibration
      {"E-UNKNOWN-KEY", five("[tool]\n@lenght = 3\n"), "'length'"},
      {"E-ZERO-VECTOR", five("[tool]\naxis = @[0, 0, 0.0]\n"), ""},
      {"E-UNKNOWN-KEY", five("[workpiece]\n@axis = [0, 0, 1]\n"), ""},
      {"E-DATE", five("[calibration]\ndate = @\"2026-02-29\"\n"), "YYYY-MM-DD"},
      {"E-DATE", five("[calibration]\ndate = @\"02.03.2026\"\n"), ""},
      {"E-DATE", five("[calibration]\nvalid_to = @2026\n"), ""},
      {"E-DATE", five("[calibration]\ndate = @2026-03-02T10:00:00\n"), ""},
      {"E-UNKNOWN-KEY", five("[calibration]\n@dat = 2026-03-02\n"), "'date'"},
      {"E-TYPE", five("[calibration]\nmachine_id = @true\n"), ""},
      {"W-VALID-TO", five("[calibration]\ndate = 2026-03-02\nvalid_to = @2025-03-02\n"), ""},
      // names of errors
      {"E-ERROR-NAME", errors("@EQX = 1"), "'E"},
      {"E-ERROR-NAME", errors("@exx = 1"), ""},
      {"E-ERROR-NAME", errors("@TX0X = 1"), ""},
      {"E-ERROR-NAME", errors("@TXt = 1"), ""},
      {"E-ERROR-NAME", errors("@EX0t = 1"), ""},
      {"E-ERROR-AXIS", errors("@EXB = 1"), "'EX"},
      {"E-ERROR-AXIS", errors("@EC0Y1 = 1"), "'EC0Y'"},
      {"E-ERROR-TWICE", errors("EC0Y = 1\n@C0Y = 1"), ""},
      // forms
      {"E-TYPE", errors("EXY = @\"3\""), "quotes"},
      {"E-TYPE", errors("EXY = @true"), ""},
      {"E-NOT-FINITE", errors("EXY = @nan"), ""},
      {"E-NOT-FINITE", errors("EXY = { poly = [1, @inf] }"), ""},
      {"E-FORM", errors("EXY = @[]"), ""},
      {"E-FORM", errors("EXY = [@[0, 0], [100, 2.1]]"), "table"},
      {"E-FORM", errors("EXY = @{}"), ""},
      {"E-FORM", errors("EXY = @{ of = \"X\" }"), ""},
      {"E-FORM", errors("EXY = @{ poly = [1], sine = [1, 2, 3] }"), ""},
      {"E-FORM", errors("EXY = { @forward = 1 }"), ""},
      {"E-UNKNOWN-KEY", errors("EXY = { @pol = [1] }"), "'poly'"},
      {"E-UNKNOWN-KEY", errors("EXY = { poly = [1], @off = \"X\" }"), "'of'"},
      {"E-FORM-KEY", errors("EXY = { poly = [1], @periodic = true }"), ""},
      {"E-FORM-KEY", errors("EXY = { forward = 1, backward = 2, @reference = 3 }"), ""},
      {"E-FORM-KEY",
       errors("EXY = { grid = [[1, 2]], at = [[0], [1, 2]], of = [\"X\", \"Y\"], @reference = 3 }"), ""},
      {"E-COUNT", errors("EXY = { poly = @[] }"), ""},
      {"E-COUNT", errors("EXY = { table = @[] }"), ""},
      {"E-COUNT", errors("EXY = { table = [@[0, 1, 2]] }"), "2"},
      {"E-COUNT", errors("EXY = { sine = @[1, 2] }"), "3"},
      {"E-POSITIONS", errors("EXY = { table = [[0, 1], [5, 2], [@5, 3]] }"), ""},
      {"E-POSITIONS", errors("EXY = { grid = [1, 2], at = [[3, @2]], of = \"X\" }"), ""},
      {"E-VALUE", errors("EXY = { table = [[0, 1]], interpolation = @\"spline\" }"), ""},
      {"E-INTERVAL", errors("EXY = { poly = [0, 1], domain = @[1, 0] }"), ""},
      {"E-GRID", errors("EXY = { grid = @[[1, 2]] }"), "at"},
      {"E-GRID", errors("EXY = { grid = [1, 2], at = @[] }"), ""},
      {"E-GRID", errors("EXY = { grid = [1, 2], at = [@[]] }"), ""},
      {"E-GRID", errors("EXY = { grid = @[1, 2], at = [[0, 1, 2]] }"), ""},
      {"E-GRID", errors("EXY = { grid = [[1, 2], @[1]], at = [[0, 1], [0, 1]], of = [\"X\", \"Y\"] }"), ""},
      {"E-GRID", errors("EXY = @{ grid = [[1, 2], [1, 2]], at = [[0, 1], [0, 1]] }"), "of"},
      {"E-GRID", errors("EXY = { grid = [[1, 2], [1, 2]], at = [[0, 1], [0, 1]], of = @[\"X\"] }"), ""},
      {"E-GRID", errors("EXY = { grid = [[1, 2], [1, 2]], at = [[0, 1], [0, 1]], of = @[\"X\", \"X\"] }"),
       ""},
      {"E-TYPE", errors("EXY = { grid = [@1, [1, 2]], at = [[0, 1], [0, 1]], of = [\"X\", \"Y\"] }"), ""},
      {"E-PERIODIC", errors("EXY = { table = [[0, 1], [90, 2]], @periodic = true }"), ""},
      {"E-PERIODIC", errors("EXA = { table = @[[0, 1], [361, 2]], periodic = true }"), ""},
      {"E-PERIODIC", errors("EXA = { table = @[[0, 1], [360, 2]], periodic = true }"), ""},
      {"E-PERIODIC", errors("EXA = { table = [[0, 1], [90, 2]], periodic = true, @domain = [0, 90] }"), ""},
      // variables
      {"E-NO-VARIABLE", errors("EXS = @{ poly = [0, 1] }"), "of"},
      {"E-NO-VARIABLE", errors("EXt = @{ sine = [0, 1, 2] }"), "of"},
      {"E-NO-VARIABLE", errors("EXt = @{ forward = 1, backward = 2 }"), "of"},
      {"E-VARIABLE", errors("EXY = { poly = [0, 1], of = @\"B\" }"), ""},
      {"E-VARIABLE", errors("EXY = { poly = [0, 1], of = @\"Y1\" }"), "'Y'"},
      {"E-VARIABLE", errors("EXY = { poly = [0, 1], of = @\"S\" }"), ""},
      {"E-VARIABLE", errors("EXY = { poly = [0, 1], of = @\"v.Q\" }"), "'v."},
      {"E-VARIABLE", errors("EXY = { poly = [0, 1], of = @\"a.S\" }"), ""},
      {"E-VARIABLE", errors("EXY = { poly = [0, 1], of = @\"u.X\" }"), ""},
      {"E-VARIABLE", errors("EXY = { poly = [0, 1], of = @\"\" }"), ""},
      {"E-VARIABLE", errors("EXY = { poly = [0, 1], of = @\"20\" }"), ""},
      {"E-VARIABLE", errors("EXY = { forward = 1, backward = 2, of = @\"T1\" }"), ""},
      {"E-TYPE", errors("EXY = { poly = [0, 1], of = @[\"X\"] }"), ""},
      {"W-SENSOR-NAME", errors("EXY = { poly = [0, 1], of = @\"x\" }"), "\"X\""},
      // uncertainty
      {"E-UNCERTAINTY", five("[errors]\nEXY = 1\n[uncertainty]\nEXY = @-1\n"), ""},
      {"E-UNCERTAINTY", five("[errors]\nEXY = 1\n[uncertainty]\nEXY = @{ poly = [1] }\n"), ""},
      {"E-UNCERTAINTY", five("[errors]\nEXY = 1\n[uncertainty]\n@EXZ = 1\n"), "EXZ = 0"},
      {"E-ERROR-NAME", five("[errors]\nEXY = 1\n[uncertainty]\n@uXY = 1\n"), ""},
      {"E-ERROR-TWICE", five("[errors]\nEC0Y = 1\n[uncertainty]\nEC0Y = 1\n@C0Y = 1\n"), ""},
      // lagged sensors
      {"E-SENSOR-LAG", five("[sensors]\n@slow = { of = \"T1\" }\n"), "lag = 1800"},
      {"E-SENSOR-LAG", five("[sensors]\nslow = { of = \"T1\", lag = @0 }\n"), ""},
      {"E-SENSOR-LAG", five("[sensors]\nslow = { of = @\"slow\", lag = 9 }\n"), ""},
      {"E-SENSOR-LAG", five("[sensors]\n@Y = { of = \"T1\", lag = 9 }\n"), "T_Y"},
      {"E-UNKNOWN-KEY", five("[sensors]\nslow = { of = \"T1\", lag = 9, @gain = 2 }\n"), ""},
      // what does not fit together
      {"W-ORDER-LEAVES-OUT",
       five("[axis.Y]\norder = @[\"motion\", \"static\"]\n[errors]\nEXY = 1\nTXY = 1\nEC0Y = 2\n"), ""},
      {"W-ORDER-LEAVES-OUT", five("[axis.Y]\norder = @[\"along\", \"motion\"]\n[errors]\nEC0Y = 1\n"), ""},
      {"W-LOCATION-TWICE", five("[axis.Y]\norder = @[\"location\", \"along\", \"motion\"]\n"), ""},
      {"W-STRAIGHTNESS-SLOPE", errors("@EXY = { poly = [0, 0.002] }\nEC0Y = 1"), "EC0Y"},
      {"W-STRAIGHTNESS-SLOPE", errors("@EXY = { table = [[0, 0], [100, 0.15], [200, 0.25]] }\nEC0X = 1"),
       "EC0X"},
      {"W-STRAIGHTNESS-SLOPE", errors("@EZY = { poly = [0, -0.002] }\nEA0Z = 1"), "EA0Z"},
      {"W-STRAIGHTNESS-SLOPE", errors("@EZX = { poly = [0, -0.002] }\nEB0Z = 1"), "EB0Z"},
  };
}

TEST(Mistakes, EveryOneIsReportedAtItsPlace) {
  for (const Mistake& mistake : mistakes()) {
    std::string text = mistake.text;
    const std::size_t at = text.find('@');
    ASSERT_NE(at, std::string::npos) << text;
    text.erase(at, 1);
    const auto line =
        static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<long>(at), '\n')) + 1;
    const std::size_t column = at - (at == 0 ? 0 : text.rfind('\n', at - 1) + 1) + 1;

    const auto parsed = read(text);
    const bool warning = mistake.code.front() == 'W';
    EXPECT_EQ(parsed.value.has_value(), warning) << text;
    const auto found =
        std::find_if(parsed.diagnostics.begin(), parsed.diagnostics.end(), [&](const Diagnostic& d) {
          return d.code == mistake.code && d.place.line == line && d.place.column == column;
        });
    if (found == parsed.diagnostics.end()) {
      ADD_FAILURE() << mistake.code << " expected at " << line << ":" << column << " of\n"
                    << text << "\nfound:\n"
                    << all_of(parsed.diagnostics);
      continue;
    }
    EXPECT_EQ(parsed.diagnostics.size(), 1u) << text << all_of(parsed.diagnostics);
    EXPECT_EQ(found->severity, warning ? Severity::warning : Severity::error);
    EXPECT_EQ(found->place.file, "folder/machine.toml");
    EXPECT_THAT(found->fix, ::testing::HasSubstr(mistake.fix)) << text;
    EXPECT_FALSE(found->message.empty());
    EXPECT_FALSE(found->fix.empty());
  }
}

TEST(Mistakes, SeveralAreReportedAtOnce) {
  const auto parsed = read(
      "format = 3\n[machine]\nchain = \"w X b Z t\"\nnmae = \"x\"\n[units]\nlength = \"cm\"\n[axis.Z]\n"
      "range = [1, 0]\n[tool]\naxis = [0, 0, 0]\n[errors]\nEXQ = 1\nEYZ = { poly = [] }\nEXX = 2\n");
  std::vector<std::string> codes;
  for (const Diagnostic& diagnostic : parsed.diagnostics) codes.push_back(diagnostic.code);
  EXPECT_THAT(codes, ::testing::ElementsAre("E-FORMAT", "E-ERRORS-SEEN", "E-UNKNOWN-KEY", "E-VALUE",
                                            "E-INTERVAL", "E-ZERO-VECTOR", "E-ERROR-AXIS", "E-COUNT"));
}

TEST(Mistakes, SmallTrendsAndOtherPairsAreNotReported) {
  for (const char* errors :
       {"EXY = { poly = [0, 0.0005] }\nEC0Y = 1",                    // below 1 urad
        "EXY = { poly = [0, 0.002] }\nEA0Y = 1",                     // another pair
        "EXY = { poly = [0, 0.002] }",                               // no squareness
        "EYY = { poly = [0, 0.002] }\nEC0Y = 1",                     // positioning
        "EXY = { table = [[-9, 81], [0, 0], [9, 81]] }\nEC0Y = 1"})  // bent, without trend
    EXPECT_TRUE(read(five_axis(std::string("[errors]\n") + errors + "\n")).diagnostics.empty()) << errors;
}

TEST(Mistakes, TheTrendIsThatOfTheTravel) {
  // 3e-5 um/mm^2: no trend about zero, 6 urad over 0..200
  const std::string errors = "[errors]\nEXY = { poly = [0, 0, 3e-5] }\nEC0Y = 1\n";
  EXPECT_TRUE(read(five_axis(errors)).diagnostics.empty());
  EXPECT_TRUE(read(five_axis("[axis.Y]\nrange = [-100, 100]\n" + errors)).diagnostics.empty());
  const auto parsed = read(five_axis("[axis.Y]\nrange = [0, 200]\n" + errors));
  ASSERT_EQ(parsed.diagnostics.size(), 1u);
  EXPECT_THAT(parsed.diagnostics[0].message, ::testing::HasSubstr(" 6 urad"));
}

TEST(Mistakes, ErrorsFileSaysWhichMachine) {
  const auto parsed = read(five_axis("[calibration]\nmachine_id = \"17\"\n"), {},
                           "format = 1\n[calibration]\nmachine_id = \"18\"\n[errors]\nEXY = 1\n");
  ASSERT_EQ(parsed.diagnostics.size(), 1u);
  EXPECT_EQ(parsed.diagnostics[0].code, "W-MACHINE-ID");
  EXPECT_EQ(parsed.diagnostics[0].place.file, "folder/errors.toml");
  EXPECT_EQ(parsed.diagnostics[0].place.line, 3u);
}

TEST(Mistakes, ErrorsFileHoldsErrorsOnly) {
  const auto parsed =
      read(five_axis(""), {}, "[machine]\nname = \"m\"\n[errors]\nEXY = { poly = [1, \"2\"] }\n");
  std::vector<std::string> codes;
  for (const Diagnostic& diagnostic : parsed.diagnostics) {
    EXPECT_EQ(diagnostic.place.file, "folder/errors.toml");
    codes.push_back(diagnostic.code);
  }
  EXPECT_THAT(codes, ::testing::ElementsAre("E-FORMAT", "E-UNKNOWN-KEY", "E-TYPE"));
}

TEST(Mistakes, DeepNestingIsRefused) {
  std::string key = "a";
  for (int i = 0; i < 100000; ++i) key += ".a";
  EXPECT_EQ(read(key + " = 1\n").diagnostics.at(0).code, "E-TOML");
  EXPECT_EQ(read("[" + key + "]\n").diagnostics.at(0).code, "E-TOML");
  EXPECT_EQ(read("x = { " + key + " = 1 }\n").diagnostics.at(0).code, "E-TOML");
  EXPECT_EQ(read("x = \"\"\"\n\"\n\"\"\"\n" + key + " = 1\n").diagnostics.at(0).place.line, 4u);
  EXPECT_FALSE(read("x = " + std::string(100000, '[')).value);
  EXPECT_TRUE(
      read("\xef\xbb\xbf" + five_axis("[calibration]\ncontrol_compensation = \"\xc3\x9c\" # \xc3\x9c\n"))
          .value);
  EXPECT_TRUE(read(five_axis("[calibration]\ncontrol_compensation = '''\\\xc3\x9c'''\n")).value);
  std::string dots;
  for (int i = 0; i < 200; ++i) dots += " 0.5,";
  EXPECT_TRUE(
      read(five_axis("[errors]\nEXY = { poly = [" + dots + "] } # a.b.c" + std::string(50, '.') + "\n"))
          .value);
  EXPECT_TRUE(
      read(five_axis("[calibration]\ncontrol_compensation = \"\\\"" + std::string(50, '.') + "\"\n")).value);
}

}  // namespace
}  // namespace abbe
