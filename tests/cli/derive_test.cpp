// `abbe derive`: the members of its JSON, the three formats, and what it says to wrong options. That the
// equations are right is the business of abbe/symbols and tests/symbols.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "machines.h"
#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class Derive : public ::testing::Test {
 protected:
  Folder folder_;
  std::string three_ = folder_.put("three.toml", kThreeAxes);
  std::string five_ = folder_.put("five.toml", kFiveAxes);
};

TEST_F(Derive, JsonHasTheMembersOfTheContract) {
  const ProgramRun run = run_abbe({"derive", five_, "--format", "json", "--contributions"});
  ASSERT_EQ(run.exit, 0) << run.err;
  const json read = json::parse(run.out);
  EXPECT_EQ(read["verb"], "derive");
  EXPECT_EQ(read["machine"]["name"], "five axes");
  EXPECT_THAT(read["errors"], ElementsAre("EXX", "EY0A"));
  EXPECT_THAT(read["axes"], ElementsAre("C", "X", "Y", "Z", "A"));
  // C turns about -z, so the tool seen from the work turns about +z. A turns about a line EY0A beside the
  // nominal one: (1 - cos A, -sin A) of it.
  const json& deviation = read["deviation"];
  EXPECT_EQ(deviation["x"], "cos(C)*EXX - sin(C)*EY0A + sin(C)*cos(A)*EY0A");
  EXPECT_EQ(deviation["y"], "cos(C)*EY0A - cos(C)*cos(A)*EY0A + sin(C)*EXX");
  EXPECT_EQ(deviation["z"], "-sin(A)*EY0A");
  EXPECT_EQ(read["tool_axis"], json::parse(R"({"x": "0", "y": "0", "z": "0"})"));
  EXPECT_EQ(read["tool_twist"]["dx"], "EXX");
  for (const char* key : {"dx", "dy", "dz", "ex", "ey", "ez"}) EXPECT_TRUE(read["tool_twist"].contains(key));
  ASSERT_EQ(read["contributions"].size(), 2U);
  EXPECT_EQ(read["contributions"][0]["error"], "EXX");
  EXPECT_EQ(read["contributions"][0]["deviation"]["y"], "sin(C)");
  EXPECT_EQ(read["contributions"][1]["tool_twist"]["dx"], "0");
}

TEST_F(Derive, JsonOptionIsTheJsonFormat) {
  EXPECT_EQ(run_abbe({"derive", three_, "--json"}).out, run_abbe({"derive", three_, "--format", "json"}).out);
  EXPECT_FALSE(json::parse(run_abbe({"derive", three_, "--json"}).out).contains("contributions"));
}

TEST_F(Derive, TextSaysWhatTheValuesAre) {
  const ProgramRun run = run_abbe({"derive", three_, "--contributions"});
  ASSERT_EQ(run.exit, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("  dx = EXX\n  dy = EYY\n  dz = TZZ\n"));
  EXPECT_THAT(run.out, HasSubstr("tool as seen from the workpiece"));
  EXPECT_THAT(run.out, HasSubstr("  EYY   dy = 1\n"));
}

TEST_F(Derive, LatexIsAnAlignEnvironment) {
  const ProgramRun run = run_abbe({"derive", three_, "--format", "latex"});
  ASSERT_EQ(run.exit, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("\\begin{align}\n  \\Delta x &= E_{XX} \\\\\n  \\Delta y &= E_{YY} \\\\\n"
                                 "  \\Delta z &= T_{ZZ}\n\\end{align}\n"));
}

TEST_F(Derive, AllTakesTheInventory) {
  const ProgramRun run = run_abbe({"derive", three_, "--all", "--json"});
  ASSERT_EQ(run.exit, 0) << run.err;
  const std::string x = json::parse(run.out)["deviation"]["x"];
  EXPECT_THAT(x, HasSubstr("EXY"));
  EXPECT_THAT(x, HasSubstr("EB0Z"));
}

TEST_F(Derive, MachineWithoutErrorsIsAWarning) {
  const std::string bare(kThreeAxes, std::string_view(kThreeAxes).find("[errors]"));
  const std::string file = folder_.put("bare.toml", bare);
  const ProgramRun run = run_abbe({"derive", file, "--strict"});
  EXPECT_EQ(run.exit, 4);
  EXPECT_THAT(run.err, HasSubstr("--all"));
  EXPECT_EQ(run_abbe({"derive", file, "--strict", "--all"}).exit, 0);
}

TEST_F(Derive, WrongOptionsAreUsage) {
  EXPECT_EQ(run_abbe({"derive", three_, "--format", "word"}).exit, 2);
  // The equations are first order whatever the model: no such option.
  EXPECT_EQ(run_abbe({"derive", three_, "--model", "rigid"}).exit, 2);
  const ProgramRun absent = run_abbe({"derive", "absent.toml"});
  EXPECT_EQ(absent.exit, 2);
  EXPECT_THAT(absent.out, Not(HasSubstr("dx")));
}

}  // namespace
}  // namespace abbe::cli
