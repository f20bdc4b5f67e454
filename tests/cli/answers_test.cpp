// Answers of the verbs that ask a machine: numbers that can be worked out by hand, and the members of
// the JSON that scripts rely on.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "machines.h"
#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kPicometre = 1e-9;  // mm
constexpr double kNanoradian = 1e-9;

void expect_vector(const json& actual, double x, double y, double z, double tolerance) {
  ASSERT_EQ(actual.size(), 3U);
  EXPECT_NEAR(actual[0], x, tolerance);
  EXPECT_NEAR(actual[1], y, tolerance);
  EXPECT_NEAR(actual[2], z, tolerance);
}

class Answers : public ::testing::Test {
 protected:
  json answer(std::vector<std::string> arguments, std::string_view input = {}, int exit = 0) {
    arguments.push_back("--json");
    const ProgramRun run = run_abbe(arguments, input, folder_.path());
    EXPECT_EQ(run.exit, exit) << run.err;
    return json::parse(run.out, nullptr, false);
  }

  Folder folder_;
  std::string three_ = folder_.put("three.toml", kThreeAxes);
  std::string five_ = folder_.put("five.toml", kFiveAxes);
};

TEST_F(Answers, PredictAddsTheErrorsAsSeenAtTheTool) {
  const json read = answer({"predict", three_, "--at", "X=100,Y=20,Z=-30", "--set", "T1=23"});
  ASSERT_EQ(read["points"].size(), 1U);
  const json& point = read["points"][0];
  EXPECT_EQ(point["q"], json::parse(R"({"X":100,"Y":20,"Z":-30})"));
  expect_vector(point["nominal"]["position_mm"], 100, 20, -30, kPicometre);
  // EXX 0.1 um/mm seen at the tool, EYY 5 um, TZZ 2 um per degree above 20.
  expect_vector(point["deviation"]["position_mm"], 0.010, 0.005, 0.006, kPicometre);
  expect_vector(point["actual"]["position_mm"], 100.010, 20.005, -29.994, kPicometre);
  expect_vector(point["tool_twist"]["translation_mm"], 0.010, 0.005, 0.006, kPicometre);
  expect_vector(point["tool_twist"]["rotation_rad"], 0, 0, 0, kNanoradian);
  expect_vector(point["nominal"]["tool_axis"], 0, 0, 1, kNanoradian);
  EXPECT_TRUE(point["extrapolated"].empty());
}

TEST_F(Answers, ErrorsOfTheTableBodyActAgainstTheTool) {
  std::string text(kThreeAxes);
  text.replace(text.find("\"tool\""), 6, "\"body\"");
  const json read = answer({"predict", folder_.put("body.toml", text), "--at", "X=100", "--set", "T1=20"});
  expect_vector(read["points"][0]["deviation"]["position_mm"], -0.010, 0.005, 0, kPicometre);
}

TEST_F(Answers, PointsComeBackInOrderWithTheirSensors) {
  const json read =
      answer({"predict", three_, "--points", "-"}, "T1,X,Y,Z\n20,100,0,0\n23,200,0,0\n23,300,0,0\n");
  ASSERT_EQ(read["points"].size(), 3U);
  expect_vector(read["points"][0]["deviation"]["position_mm"], 0.010, 0.005, 0, kPicometre);
  expect_vector(read["points"][1]["deviation"]["position_mm"], 0.020, 0.005, 0.006, kPicometre);
  expect_vector(read["points"][2]["deviation"]["position_mm"], 0.030, 0.005, 0.006, kPicometre);
  EXPECT_TRUE(read["complete"]);
}

TEST_F(Answers, PointsComeThroughAPipe) {
  const std::string pipe = folder_ / "points";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << "X,Y,Z\n100,0,0\n200,0,0\n"; });
  const json read = answer({"predict", three_, "--set", "T1=20", "--points", pipe});
  writer.join();
  ASSERT_EQ(read["points"].size(), 2U);
  expect_vector(read["points"][1]["deviation"]["position_mm"], 0.020, 0.005, 0, kPicometre);
}

TEST_F(Answers, ApproachIsTakenFromTheOptionAndFromTheColumn) {
  // EYY is 5 um, +1 forward and -1 backward.
  const std::string machine =
      folder_.put("lost.toml", std::string(kThreeAxes) + "EXY = { forward = 1, backward = -1 }\n");
  const std::vector<std::string> at = {"predict", machine, "--set", "T1=20", "--at", "X=0"};
  const auto x_of = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = at;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return answer(arguments)["points"][0]["deviation"]["position_mm"][0].get<double>();
  };
  EXPECT_NEAR(x_of({}), 0, kPicometre);
  EXPECT_NEAR(x_of({"--approach", "Y=+"}), 0.001, kPicometre);
  EXPECT_NEAR(x_of({"--approach", "Y=-"}), -0.001, kPicometre);
  const json rows = answer({"predict", machine, "--set", "T1=20", "--points", "-"},
                           "X,Y,Z,Y.dir\n0,0,0,+\n0,0,0,-\n0,0,0,0\n");
  EXPECT_NEAR(rows["points"][0]["deviation"]["position_mm"][0], 0.001, kPicometre);
  EXPECT_NEAR(rows["points"][1]["deviation"]["position_mm"][0], -0.001, kPicometre);
  EXPECT_NEAR(rows["points"][2]["deviation"]["position_mm"][0], 0, kPicometre);
}

TEST_F(Answers, VelocitiesComeFromColumnsAndFromSet) {
  const std::string machine =
      folder_.put("fast.toml", std::string(kThreeAxes) + "DYY = { poly = [0, 0.02], of = \"v.Y\" }\n");
  const json rows =
      answer({"predict", machine, "--set", "T1=20", "--points", "-"}, "X,Y,Z,v.Y\n0,0,0,100\n0,0,0,-50\n");
  EXPECT_NEAR(rows["points"][0]["deviation"]["position_mm"][1], 0.007, kPicometre);
  EXPECT_NEAR(rows["points"][1]["deviation"]["position_mm"][1], 0.004, kPicometre);
  const json set = answer({"predict", machine, "--set", "T1=20,v.Y=100", "--at", "X=0"});
  EXPECT_NEAR(set["points"][0]["deviation"]["position_mm"][1], 0.007, kPicometre);
}

TEST_F(Answers, PredictReportsWhatIsOutsideAndGoesOn) {
  const json read = answer({"predict", three_, "--at", "X=500", "--set", "T1=20"});
  EXPECT_THAT(read["points"][0]["outside_travel"], ElementsAre("X"));
  const std::string machine =
      folder_.put("table.toml", std::string(kThreeAxes) + "EZY = { table = [[0, 1], [50, 2]] }\n");
  EXPECT_THAT(answer({"predict", machine, "--at", "Y=60", "--set", "T1=20"})["points"][0]["extrapolated"],
              ElementsAre("EZY"));
}

TEST_F(Answers, LimitsPassOrFail) {
  const std::vector<std::string> at = {"predict", three_, "--at", "X=100", "--set", "T1=20", "--limit-um"};
  const auto with = [&](const char* limit, bool strict, int exit) {
    std::vector<std::string> arguments = at;
    arguments.emplace_back(limit);
    if (strict) arguments.emplace_back("--strict");
    return answer(arguments, {}, exit);
  };
  EXPECT_TRUE(with("11.19", false, 0)["pass"]);  // sqrt(10^2 + 5^2) = 11.18
  EXPECT_FALSE(with("11.17", false, 0)["pass"]);
  EXPECT_FALSE(with("11.17", false, 0)["points"][0]["pass"]);
  EXPECT_TRUE(with("11.19", true, 0)["pass"]);
  EXPECT_FALSE(with("11.17", true, 4)["pass"]);
}

TEST_F(Answers, CorrectBringsTheTipBack) {
  const json read = answer({"correct", three_, "--at", "X=100,Y=20,Z=-30", "--set", "T1=23"});
  const json& point = read["points"][0];
  EXPECT_EQ(point["commanded"]["X"], 100);
  // x + 1e-4 x = 100
  EXPECT_NEAR(point["corrected"]["X"], 100 / 1.0001, kPicometre);
  EXPECT_NEAR(point["corrected"]["Y"], 20 - 0.005, kPicometre);
  EXPECT_NEAR(point["corrected"]["Z"], -30 - 0.006, kPicometre);
  EXPECT_EQ(point["status"], "ok");
  EXPECT_LT(point["residual"]["position_mm"], 1e-6);
  EXPECT_TRUE(point["iterations"].is_number_integer());
  const json step = answer({"correct", three_, "--at", "X=100", "--set", "T1=20", "--method", "one-step"});
  EXPECT_NEAR(step["points"][0]["corrected"]["X"], 99.990, 2e-6);
}

TEST_F(Answers, CorrectLeavesLockedAxesAlone) {
  const json read = answer({"correct", three_, "--at", "X=100", "--set", "T1=20", "--lock", "X"});
  EXPECT_EQ(read["points"][0]["corrected"]["X"], 100);
  EXPECT_EQ(read["points"][0]["status"], "partial");
  EXPECT_NEAR(read["points"][0]["residual"]["position_mm"], 0.010, 1e-6);
}

TEST_F(Answers, CorrectOutsideEndsWithFive) {
  EXPECT_EQ(run_abbe({"correct", three_, "--at", "X=500", "--set", "T1=20"}).exit, 5);
  const std::string machine =
      folder_.put("table.toml", std::string(kThreeAxes) + "EZY = { table = [[0, 1], [50, 2]] }\n");
  const ProgramRun run = run_abbe({"correct", machine, "--at", "Y=60", "--set", "T1=20"});
  EXPECT_EQ(run.exit, 5);
  EXPECT_THAT(run.err, HasSubstr("E-VOL"));
}

TEST_F(Answers, RotaryPositionsAreInDegrees) {
  const json read = answer({"predict", five_, "--at", "A=90,C=0"});
  const json& point = read["points"][0];
  EXPECT_EQ(point["q"]["A"], 90);
  // The head turns the tool axis +z about +x by 90 degrees: to -y. Pivot at z = 200, tip 200 below it.
  expect_vector(point["nominal"]["tool_axis"], 0, -1, 0, kNanoradian);
  expect_vector(point["nominal"]["position_mm"], 0, 200, 200, kPicometre);
}

TEST_F(Answers, InverseOfPredictIsTheCommand) {
  const json pose = answer({"predict", five_, "--at", "X=10,Y=20,Z=30,A=25,C=40"})["points"][0];
  std::string text;
  for (const char* part : {"position_mm", "tool_axis"}) {
    for (const double number : pose["actual"][part]) text += (text.empty() ? "" : ",") + json(number).dump();
  }
  const json read = answer({"inverse", five_, "--pose", text, "--near", "A=20,C=30"});
  const json& q = read["points"][0]["q"];
  for (const auto& [axis, value] :
       {std::pair{"X", 10.0}, {"Y", 20.0}, {"Z", 30.0}, {"A", 25.0}, {"C", 40.0}}) {
    EXPECT_NEAR(q[axis], value, 1e-6) << axis;
  }
  EXPECT_EQ(read["points"][0]["status"], "ok");
  EXPECT_EQ(read["points"][0]["pose"].size(), 6U);
  EXPECT_TRUE(read["points"][0]["branch"].is_number_integer());
  EXPECT_LT(read["points"][0]["residual"]["position_mm"], 1e-6);
  EXPECT_LT(read["points"][0]["residual"]["direction_rad"], 1e-9);

  const json rows =
      answer({"inverse", five_, "--poses", "-", "--ideal"}, "x,y,z,i,j,k\n1,2,3,0,0,1\n4,5,6,0,0,1\n");
  ASSERT_EQ(rows["points"].size(), 2U);
  EXPECT_NEAR(rows["points"][1]["q"]["X"], 4, kPicometre);
}

TEST_F(Answers, DescribeNumbersBodiesFromTheBed) {
  const json read = answer({"describe", five_});
  std::vector<std::string> names;
  for (const json& body : read["bodies"]) names.push_back(body["name"]);
  EXPECT_THAT(names, ElementsAre("b", "Y", "Z", "A", "t", "X", "C", "w"));
  EXPECT_EQ(read["lower_body_array"][0], json::array({1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(read["lower_body_array"][1], json::array({0, 1, 2, 3, 0, 5, 6}));
  EXPECT_EQ(read["axes"][0]["name"], "C");
  EXPECT_EQ(read["axes"][0]["branch"], "workpiece");
  EXPECT_EQ(read["axes"][0]["type"], "rotary");
  EXPECT_EQ(read["axes"][0]["range"], nullptr);
  expect_vector(read["axes"][1]["direction"], -1, 0, 0, 0);
  EXPECT_EQ(read["axes"][4]["range"], json::array({-100, 100}));
  expect_vector(read["axes"][4]["origin_mm"], 0, 0, 200, 0);
  EXPECT_EQ(read["errors"]["count"], 2);
  EXPECT_THAT(read["errors"]["names"], ElementsAre("EXX", "EY0A"));
  EXPECT_GE(read["inventory"].size(), 30U);
}

TEST_F(Answers, SigncheckShowsWhichWayTheToolGoes) {
  const json read = answer({"signcheck", three_, "--set", "T1=20"});
  expect_vector(read["axes"][0]["tip_motion_mm"], 10, 0, 0,
                kPicometre);  // X+ moves the tool to +x of the work
  expect_vector(read["axes"][0]["body_motion_mm"], -10, 0, 0, kPicometre);  // because the table moves to -x
  const json& exx = read["errors"][0];
  EXPECT_EQ(exx["name"], "EXX");
  EXPECT_EQ(exx["move"]["axis"], "X");
  const double length = exx["move"]["to"].get<double>() - exx["move"]["from"].get<double>();
  EXPECT_GT(length, 0);
  EXPECT_NEAR(exx["tip_change_mm"][0], 1e-4 * length, kPicometre);
  const json& tzz = read["errors"][2];
  EXPECT_EQ(tzz["move"]["sensor"], "T1");
  expect_vector(tzz["tip_change_mm"], 0, 0, 0.002, kPicometre);
}

TEST_F(Answers, ModelsDifferOnlyAtSecondOrder) {
  const std::string machine = folder_.put("tilt.toml", std::string(kThreeAxes) + "EAY = 1000\n");
  const auto y_of = [&](const char* model) {
    return answer({"predict", machine, "--at", "Z=100", "--set", "T1=20", "--model",
                   model})["points"][0]["deviation"]["position_mm"][1]
        .get<double>();
  };
  const double rigid = y_of("rigid"), linear = y_of("linear"), first = y_of("first-order");
  EXPECT_NEAR(first, 0.005 - 100 * 1e-3, 1e-8);
  EXPECT_NEAR(rigid, linear, 1e-4);
  EXPECT_NE(rigid, linear);
}

TEST_F(Answers, HumanTextCarriesUnitsAndSigns) {
  const ProgramRun run = run_abbe({"predict", three_, "--at", "X=100", "--set", "T1=20"});
  EXPECT_EQ(run.exit, 0);
  EXPECT_THAT(run.out, HasSubstr("+10.000"));
  EXPECT_THAT(run.out, HasSubstr("um"));
  const ProgramRun table =
      run_abbe({"correct", three_, "--points", "-", "--set", "T1=20"}, "X,Y,Z\n100,0,0\n200,0,0\n");
  EXPECT_EQ(table.exit, 0);
  EXPECT_THAT(table.out, HasSubstr("2 points: 2 ok"));
}

TEST_F(Answers, LongTablesStream) {
  std::string rows = "X,Y,Z\n";
  constexpr int kRows = 20000;
  for (int i = 0; i < kRows; ++i) rows += std::to_string(i % 400) + ",1,2\n";
  const json read = answer({"predict", three_, "--points", folder_.put("long.csv", rows), "--set", "T1=20"});
  ASSERT_EQ(read["points"].size(), static_cast<std::size_t>(kRows));
  EXPECT_NEAR(read["points"][399]["deviation"]["position_mm"][0], 0.0399, kPicometre);
  EXPECT_EQ(read["summary"]["points"], kRows);
}

}  // namespace
}  // namespace abbe::cli
