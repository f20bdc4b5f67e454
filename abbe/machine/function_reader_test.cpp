#include "abbe/machine/function_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "abbe/machine/test_machines.h"

namespace abbe {
namespace {

using test::all_of;
using test::five_axis;
using test::read;

/// Reads one error and evaluates it, in the numbers of the file.
class OneError {
 public:
  explicit OneError(const std::string& text, const std::map<std::string, std::string>& files = {})
      : parsed_(read(five_axis("[errors]\n" + text + "\n"), files)) {
    EXPECT_TRUE(parsed_.value) << all_of(parsed_.diagnostics);
  }

  double at(const std::map<std::string, double>& set, int approach = 0, bool* outside = nullptr) const {
    if (!parsed_.value) return std::nan("");
    const Machine& machine = *parsed_.value;
    std::vector<double> variables(machine.variables.size(), 0.0);
    std::size_t known = 0;
    for (std::size_t i = 0; i < variables.size(); ++i) {
      const auto value = set.find(machine.variables[i].name);
      if (value == set.end()) continue;
      variables[i] = value->second;
      ++known;
    }
    EXPECT_EQ(known, set.size()) << "a variable that the machine does not have";
    const std::vector<signed char> directions(variables.size(), static_cast<signed char>(approach));
    return machine.errors.at(0).function.value<double>(variables.data(), directions.data(), outside);
  }

  bool outside(const std::map<std::string, double>& set) const {
    bool held = false;
    at(set, 0, &held);
    return held;
  }

  const Machine& machine() const { return *parsed_.value; }

 private:
  Parsed<Machine> parsed_;
};

TEST(FunctionReader, NumbersAndSums) {
  EXPECT_EQ(OneError("EXY = -57.78").at({}), -57.78);
  EXPECT_EQ(OneError("EXY = 3").at({}), 3);
  EXPECT_EQ(OneError("EXY = [1, 2.5, { poly = [0, 1] }]").at({{"Y", 10}}), 13.5);
  EXPECT_EQ(OneError("EXt = { poly = [4] }").at({}), 4);
  EXPECT_EQ(OneError("EXt = { table = [[0, 4]] }").at({}), 4);
}

TEST(FunctionReader, PolynomialOfTheOwnAxis) {
  EXPECT_EQ(OneError("EXY = { poly = [1, 2, 3] }").at({{"Y", 10}}), 321);
  EXPECT_EQ(OneError("EXY.poly = [1, 2, 3]").at({{"Y", 10}}), 321);
  EXPECT_EQ(OneError("EC0Y = { poly = [0, 2] }").at({{"Y", 10}}), 20);
}

TEST(FunctionReader, OtherVariablesAndReference) {
  const OneError thermal("TZX = { poly = [0, 2.5], of = \"T1\", reference = 20 }");
  EXPECT_EQ(thermal.at({{"T1", 24}}), 10);
  EXPECT_EQ(thermal.machine().variables.back().kind, Variable::Kind::sensor);
  const OneError dynamic("DXX = { poly = [0, 0.02], of = \"a.X\" }");
  EXPECT_DOUBLE_EQ(dynamic.at({{"a.X", 100}}), 2);
  EXPECT_EQ(dynamic.machine().variables.back().kind, Variable::Kind::acceleration);
  EXPECT_EQ(dynamic.machine().variables.back().axis, dynamic.machine().find_axis("X"));
  EXPECT_EQ(OneError("EXY = { poly = [0, 1], of = \"v.C\" }").machine().variables.back().kind,
            Variable::Kind::velocity);
  EXPECT_EQ(OneError("EXY = { poly = [0, 1], of = \"t\" }").at({{"t", 7}}), 7);
  EXPECT_EQ(OneError("EXS = { poly = [0, 1], of = \"Z\" }").at({{"Z", 7}}), 7);
}

TEST(FunctionReader, TablesAreOfTheVariableAfterTheReference) {
  const OneError table("EXY = { table = [[0, 1], [100, 3]], reference = 50 }");
  EXPECT_DOUBLE_EQ(table.at({{"Y", 100}}), 2);  // v = 50
  EXPECT_TRUE(table.outside({{"Y", 40}}));      // v = -10
  EXPECT_FALSE(table.outside({{"Y", 150}}));    // v = 100
  EXPECT_EQ(table.at({{"Y", 1000}}), 3);
}

TEST(FunctionReader, DomainIsOfTheVariableBeforeTheReference) {
  const OneError poly("EXY = { poly = [0, 1], reference = 50, domain = [40, 60] }");
  EXPECT_EQ(poly.at({{"Y", 55}}), 5);
  EXPECT_EQ(poly.at({{"Y", 70}}), 10);
  EXPECT_TRUE(poly.outside({{"Y", 61}}));
  EXPECT_FALSE(poly.outside({{"Y", 41}}));
}

TEST(FunctionReader, CubicIsTheNaturalSpline) {
  // y'' = 0 at the ends: through (0,0) (1,1) (2,0) the value at 0.5 is 0.6875
  EXPECT_NEAR(
      OneError("EXY = { table = [[0, 0], [1, 1], [2, 0]], interpolation = \"cubic\" }").at({{"Y", 0.5}}),
      0.6875, 1e-14);
  EXPECT_DOUBLE_EQ(
      OneError("EXY = { table = [[0, 0], [1, 1], [2, 0]], interpolation = \"linear\" }").at({{"Y", 0.5}}),
      0.5);
}

TEST(FunctionReader, PeriodicTablesRepeatAfterATurn) {
  const OneError table("EXA = { table = [[0, 0], [90, 9], [270, -9]], periodic = true }");
  EXPECT_NEAR(table.at({{"A", 405}}), 4.5, 1e-12);
  EXPECT_NEAR(table.at({{"A", -45}}), -4.5, 1e-12);
  EXPECT_FALSE(table.outside({{"A", 1000}}));
  EXPECT_NEAR(OneError("EXA = { table = [[0, 1], [180, 2], [360, 1]], periodic = true }").at({{"A", 450}}),
              1.5, 1e-12);
  EXPECT_TRUE(OneError("EXA = { table = [[0, 0], [90, 9]], periodic = false }").outside({{"A", 91}}));
  const auto rad_file =
      read(five_axis("[units]\nangle = \"rad\"\n[errors]\nEXA = { table = [[0, 1], [3.1415927, 2], "
                     "[6.2831853, 1]], periodic = true }\n"));
  ASSERT_TRUE(rad_file.value) << all_of(rad_file.diagnostics);
  std::vector<double> variables(5, 0.0);
  variables[4] = 2.5 * std::acos(-1.0);
  EXPECT_NEAR(rad_file.value->errors[0].function.value<double>(variables.data(), nullptr, nullptr), 1.5,
              1e-7);
}

TEST(FunctionReader, SineIsInRadians) {
  EXPECT_NEAR(OneError("EXY = { sine = [0.4, 0.628, 0.1] }").at({{"Y", 3}}), 0.4 * std::sin(0.628 * 3 + 0.1),
              1e-15);
}

TEST(FunctionReader, ProductsTakeTheirOwnVariables) {
  const OneError product("EZY = { poly = [0, 1e-3], of = \"X\", times = { poly = [1, 2], of = \"Y\" } }");
  EXPECT_DOUBLE_EQ(product.at({{"X", 100}, {"Y", 3}}), 0.1 * 7);
  // `of` of times defaults to the own axis, not to that of the first factor
  EXPECT_DOUBLE_EQ(
      OneError("EZY = { poly = [0, 1], of = \"X\", times = { poly = [0, 1] } }").at({{"X", 5}, {"Y", 3}}),
      15);
  EXPECT_DOUBLE_EQ(OneError("EZY = { poly = [0, 1], times = [2, { poly = [0, 1], of = \"T1\", times = 3 }] }")
                       .at({{"Y", 5}, {"T1", 4}}),
                   5 * (2 + 12));
}

TEST(FunctionReader, GridsAreMultilinearTheLastVariableFastest) {
  const OneError grid(
      "EYY = { grid = [[0, 1, 2], [0.5, 1.5, 3]], at = [[0, 500], [18, 20, 24]], of = [\"Y\", \"T1\"] }");
  EXPECT_DOUBLE_EQ(grid.at({{"Y", 0}, {"T1", 20}}), 1);
  EXPECT_DOUBLE_EQ(grid.at({{"Y", 500}, {"T1", 24}}), 3);
  EXPECT_DOUBLE_EQ(grid.at({{"Y", 250}, {"T1", 22}}), 0.25 * (1 + 2 + 1.5 + 3));
  EXPECT_TRUE(grid.outside({{"Y", 501}, {"T1", 20}}));
  const OneError line("EYY = { grid = [1, 3], at = [[0, 100]], reference = 50 }");
  EXPECT_DOUBLE_EQ(line.at({{"Y", 100}}), 2);
  EXPECT_DOUBLE_EQ(OneError("EYY = { grid = [1, 3], at = [[0, 100]], of = [\"X\"] }").at({{"X", 50}}), 2);
}

TEST(FunctionReader, DirectionOfApproachChooses) {
  const OneError error("EXZ = { forward = { poly = [0.5] }, backward = { poly = [-1.5] } }");
  EXPECT_EQ(error.at({{"Z", 5}}, 1), 0.5);
  EXPECT_EQ(error.at({{"Z", 5}}, -1), -1.5);
  EXPECT_EQ(error.at({{"Z", 5}}, 0), -0.5);
  EXPECT_TRUE(error.machine().errors[0].function.is_directional());
  EXPECT_EQ(OneError("EXt = { forward = 1, backward = 2, of = \"X\" }").at({}, 1), 1);
  EXPECT_EQ(OneError("EXZ = { forward = 1, backward = 2, times = { poly = [0, 1] } }").at({{"Z", 5}}, 1), 5);
}

TEST(FunctionReader, DomainOfADirectionalFormHoldsItsForms) {
  const OneError error(
      "EXZ = { forward = { poly = [0, 1] }, backward = { poly = [0, 2], domain = [0, 5] }, domain = [0, 10] "
      "}");
  EXPECT_EQ(error.at({{"Z", 20}}, 1), 10);
  EXPECT_EQ(error.at({{"Z", 20}}, -1), 10);
  EXPECT_TRUE(error.outside({{"Z", 11}}));
}

TEST(FunctionReader, CsvTablesWithNamedColumns) {
  const std::map<std::string, std::string> files{
      {"folder/a.csv", "\xef\xbb\xbfn, Y , EAX,EXY\r\n1,0,x,1\r\n\r\n# a remark\r\n2,100,y,3\r\n"},
      {"folder/b.csv", "pos;EXY\n0;1\n10;2,5\n"},
      {"folder/c.csv", "\n\"pos\"\t\"err\"\n0\t1e0\n+10\t-2.5"},
      {"/abs/d.csv", "T1,EXY\n20,0\n30,5\n"}};
  EXPECT_DOUBLE_EQ(OneError("EXY = { csv = \"a.csv\", column = \"EXY\" }", files).at({{"Y", 50}}), 2);
  EXPECT_DOUBLE_EQ(OneError("EXY = { csv = \"a.csv\" }", files).at({{"Y", 25}}), 1.5);
  EXPECT_DOUBLE_EQ(OneError("EXY = { csv = \"c.csv\", column = \"err\" }", files).at({{"Y", 10}}), -2.5);
  EXPECT_DOUBLE_EQ(OneError("EXY = { csv = \"/abs/d.csv\", of = \"T1\" }", files).at({{"T1", 25}}), 2.5);
  const auto comma = read(five_axis("[errors]\nEXY = { csv = \"b.csv\" }\n"), files);
  ASSERT_EQ(comma.diagnostics.size(), 1u);  // a decimal comma is no number
  EXPECT_EQ(comma.diagnostics[0].code, "E-CSV-CELL");
  EXPECT_EQ(comma.diagnostics[0].place.column, 4u);
}

TEST(FunctionReader, UncertaintyFromCsv) {
  const std::map<std::string, std::string> files{{"folder/u.csv", "Y,u\n0,1\n100,3\n"},
                                                 {"folder/n.csv", "Y,u\n0,1\n100,-3\n"}};
  const auto good =
      read(five_axis("[errors]\nEXY = 1\n[uncertainty]\nEXY = { csv = \"u.csv\", column = \"u\" }\n"), files);
  ASSERT_TRUE(good.value) << all_of(good.diagnostics);
  std::vector<double> variables(5, 0.0);
  variables[2] = 50;
  EXPECT_DOUBLE_EQ(good.value->errors[0].uncertainty->value<double>(variables.data(), nullptr, nullptr), 2);
  const auto bad =
      read(five_axis("[errors]\nEXY = 1\n[uncertainty]\nEXY = { csv = \"n.csv\", column = \"u\" }\n"), files);
  ASSERT_EQ(bad.diagnostics.size(), 1u);
  EXPECT_EQ(bad.diagnostics[0].code, "E-UNCERTAINTY");
}

TEST(FunctionReader, CsvMistakesHaveTheirPlaceInTheCsv) {
  struct Case {
    std::string code, csv;
    std::size_t line, column;
    bool in_csv;
  };
  for (const Case& c : std::vector<Case>{{"E-CSV-CELL", "Y,EXY\n0,1\n10,abc\n", 3, 4, true},
                                         {"E-CSV-CELL", "Y,EXY\n0, nan\n", 2, 4, true},
                                         {"E-CSV-CELL", "Y,EXY\n0,\n", 2, 3, true},
                                         {"E-CSV-CELL", "Y,EXY\n0\n", 2, 2, true},
                                         {"E-POSITIONS", "Y,EXY\n5,1\n 5,2\n", 3, 2, true},
                                         {"E-CSV-COLUMN", "Y,EXX\n5,1\n", 10, 15, false},
                                         {"E-CSV-COLUMN", "EXY,EXX\n5,1\n", 10, 15, false},
                                         {"E-CSV-COLUMN", "Y,EXY,EXY\n5,1,2\n", 10, 15, false},
                                         {"E-CSV-FILE", "Y,EXY\n", 10, 15, false},
                                         {"E-CSV-FILE", "\n\n", 10, 15, false}}) {
    const auto parsed = read(five_axis("[errors]\nEXY = { csv = \"a.csv\" }\n"), {{"folder/a.csv", c.csv}});
    ASSERT_EQ(parsed.diagnostics.size(), 1u) << c.csv << all_of(parsed.diagnostics);
    const Diagnostic& found = parsed.diagnostics[0];
    EXPECT_EQ(found.code, c.code) << c.csv;
    EXPECT_EQ(found.place.line, c.line) << c.csv;
    EXPECT_EQ(found.place.column, c.column) << c.csv;
    EXPECT_EQ(found.place.file, c.in_csv ? "folder/a.csv" : "folder/machine.toml");
    EXPECT_FALSE(parsed.value);
  }
  EXPECT_EQ(read(five_axis("[errors]\nEXY = { csv = \"a.csv\" }\n")).diagnostics.at(0).code, "E-CSV-FILE");
}

TEST(FunctionReader, NumbersTooLargeToCalculateWithAreRefused) {
  const auto parsed = read(five_axis("[errors]\nEXY = { table = [[-1e308, 1], [1e308, 2]] }\n"));
  EXPECT_FALSE(parsed.value);
  EXPECT_EQ(parsed.diagnostics.at(0).code, "E-FUNCTION");
}

}  // namespace
}  // namespace abbe
