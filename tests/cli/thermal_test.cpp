// From logs of temperature and drift to a prediction; the uncertainty of a map; a warm workpiece.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class Thermal : public ::testing::Test {
 protected:
  ProgramRun run(std::vector<std::string> arguments) { return run_abbe(arguments, {}, folder_.path()); }
  json ask(std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const ProgramRun result = run(std::move(arguments));
    EXPECT_EQ(result.exit, 0) << result.err;
    return result.exit == 0 ? json::parse(result.out) : json();
  }

  Folder folder_;
  std::string mill_ =
      folder_.put("mill.toml",
                  "format = 1\n[machine]\nname = \"mill\"\nchain = \"w X b Y Z S t\"\n[axis.X]\nrange = "
                  "[0, 500]\nerrors_seen = \"tool\"\n[axis.Y]\nrange = [0, 400]\n[axis.Z]\nrange = [-300, "
                  "0]\n[tool]\norigin = [0, 0, 400]\nlength = 100\n");
  std::string hidden_ = folder_.put("hidden.toml",
                                    "format = 1\n[errors]\nTZS = { poly = [0, 3], of = \"slow\", reference = "
                                    "20 }\n[sensors]\nslow = { of = "
                                    "\"spindle\", lag = 1800 }\n");
  std::string job_ = folder_.put(
      "job.toml",
      "format = 1\nmachine = \"mill.toml\"\n[thermal]\nerrors = [\"TZS\"]\nsensors = [\"spindle\", "
      "\"hall\"]\n"
      "[[drift]]\nfile = \"a.csv\"\nreadings = { Z1 = { direction = \"Z\" } }\n"
      "[[drift]]\nfile = \"b.csv\"\nuse = \"validation\"\nreadings = { Z1 = { direction = \"Z\" } }\n");
};

TEST_F(Thermal, LogsBecomeErrorsThatALogAnswers) {
  ASSERT_EQ(run({"simulate", "drift", job_, "--errors", "hidden.toml", "--seed", "2"}).exit, 0);
  EXPECT_EQ(run({"simulate", "drift", job_, "--errors", "hidden.toml"}).exit, 2);  // not over measurements
  const json fit = ask({"fit", job_, "-o", folder_ / "errors.toml"})["thermal"]["models"][0];
  EXPECT_EQ(fit["name"], "TZS");
  EXPECT_FALSE(fit["misfit"].get<bool>());
  EXPECT_LT(fit["validation_rms"].get<double>(), 0.2 * fit["validation_before_rms"].get<double>());
  ASSERT_EQ(fit["terms"].size(), 1U);
  EXPECT_NEAR(fit["terms"][0]["lag_s"].get<double>(), 1800, 200);
  // Without the log the lagged sensor is missing, and the message says how to give it.
  const ProgramRun missing = run({"predict", "mill.toml", "--errors", "errors.toml", "--at", "X=0,Y=0,Z=0"});
  EXPECT_EQ(missing.exit, 2);
  EXPECT_THAT(missing.err, HasSubstr("--environment LOG.csv"));
  // With it found and hidden errors agree on the last row of a log that was not fitted, as far as it is as
  // warm as those that were: beyond them the model is held.
  std::ifstream rows(folder_ / "b.csv");
  std::string part;
  double spindle = 0, time = 0;
  for (std::string line; std::getline(rows, line) && spindle < 26; part += line + '\n')
    std::sscanf(line.c_str(), "%lf,%lf", &time, &spindle);
  ASSERT_GT(time, 1800);
  folder_.put("part.csv", part);
  const auto z_of = [&](const std::string& errors) {
    return ask({"predict", "mill.toml", "--errors", errors, "--environment", "part.csv", "--at",
                "X=0,Y=0,Z=0"})["points"][0]["deviation"]["position_mm"][2]
        .get<double>();
  };
  EXPECT_NEAR(z_of("errors.toml"), z_of("hidden.toml"), 0.6e-3);
  EXPECT_GT(std::abs(z_of("hidden.toml")), 2e-3);
}

TEST_F(Thermal, LogsMayBeginWarm) {
  ASSERT_EQ(run({"simulate", "drift", job_, "--errors", "hidden.toml", "--seed", "2"}).exit, 0);
  std::ifstream cold(folder_ / "a.csv");
  std::string warm;
  int row = 0;
  for (std::string line; std::getline(cold, line); ++row)
    if (row == 0 || row > 100) warm += line + '\n';
  folder_.put("a.csv", warm);
  const json model = ask({"fit", job_})["thermal"]["models"][0];
  ASSERT_EQ(model["terms"].size(), 1U);
  EXPECT_NEAR(model["terms"][0]["slope_per_K"].get<double>(), 3, 0.3);
  EXPECT_NEAR(model["terms"][0]["lag_s"].get<double>(), 1800, 200);
  ASSERT_EQ(model["starts"].size(), 1U);
  EXPECT_THAT(run({"fit", job_}).out, HasSubstr("left over when " + folder_ / "a.csv" + " began"));
}

TEST_F(Thermal, MapsAreAsUncertainAsTheirTemperatures) {
  ASSERT_EQ(run({"simulate", "drift", job_, "--errors", "hidden.toml", "--seed", "2"}).exit, 0);
  const json fit = ask({"fit", job_, "--covariance", "-o", folder_ / "errors.toml"})["thermal"]["models"][0];
  const std::string variable = fit["terms"][0]["variable"];
  const auto u_z = [&](int degrees) {
    return ask({"map", "mill.toml", "--errors", "errors.toml", "--count", "2", "--trials", "0", "--set",
                variable + "=" + std::to_string(degrees),
                "--uncertainty"})["uncertainty"]["first_order"]["max_u_um"][2]
        .get<double>();
  };
  const double u = fit["terms"][0]["u"], beyond = u_z(20);
  EXPECT_GT(beyond, 0);
  EXPECT_NEAR(u_z(26), std::hypot(beyond, 6 * u), 1e-3 * u_z(26));
}

TEST_F(Thermal, ShortLogsAreWarnedOf) {
  folder_.put("log.csv", "time [min],spindle [degC]\n0,20\n10,25\n");
  const ProgramRun run_short = run(
      {"predict", "mill.toml", "--errors", "hidden.toml", "--environment", "log.csv", "--at", "X=0,Y=0,Z=0"});
  EXPECT_EQ(run_short.exit, 0);
  EXPECT_THAT(run_short.err, HasSubstr("W-SENSOR-LOG"));
  folder_.put("log.csv", "time [min],spindle [degC]\n10,20\n0,25\n");
  EXPECT_EQ(run({"predict", "mill.toml", "--errors", "hidden.toml", "--environment", "log.csv", "--at",
                 "X=0,Y=0,Z=0"})
                .exit,
            2);
}

TEST_F(Thermal, MapTellsItsUncertainty) {
  folder_.put("errors.toml",
              "format = 1\n[errors]\nEXX = 3\nEC0Y = 10\n[uncertainty]\nEXX = 1.5\nEC0Y = 10\n");
  const json u = ask({"map", "mill.toml", "--errors", "errors.toml", "--count", "5", "--uncertainty",
                      "--trials", "400"})["uncertainty"];
  // EC0Y turns Y by 10 urad: 4 um in X at Y = 400, beside 1.5 um
  EXPECT_NEAR(u["first_order"]["max_u_um"][0].get<double>(), std::hypot(4.0, 1.5), 1e-6);
  EXPECT_NEAR(u["monte_carlo"]["max_u_um"][0].get<double>(), std::hypot(4.0, 1.5), 0.8);
  EXPECT_LT(u["max_distance"]["low_95_um"].get<double>(), u["max_distance"]["high_95_um"].get<double>());
  EXPECT_THAT(
      run({"map", "mill.toml", "--errors", "errors.toml", "--count", "2", "--uncertainty", "--trials", "1"})
          .err,
      HasSubstr("one trial has no spread"));
  EXPECT_EQ(run({"map", "mill.toml", "--errors", "hidden.toml", "--set", "slow=22", "--uncertainty"}).exit,
            2);
}

TEST_F(Thermal, StandardInputCannotStateAnUncertainty) {
  // It is read twice: the second time [[uncertainty_mode]] would be missing.
  const ProgramRun result = run_abbe({"map", "mill.toml", "--errors", "-", "--count", "2", "--uncertainty"},
                                     "format = 1\n[errors]\nEXX = 3\n[uncertainty]\nEXX = 1.5\n"
                                     "[[uncertainty_mode]]\nEXX = 9\n",
                                     folder_.path());
  EXPECT_EQ(result.exit, 2);
  EXPECT_THAT(result.err, HasSubstr("write them to a file"));
}

TEST_F(Thermal, LogsAloneAreNoLackOfEquations) {
  ASSERT_EQ(run({"simulate", "drift", job_, "--errors", "hidden.toml", "--seed", "2"}).exit, 0);
  EXPECT_THAT(run({"fit", job_}).err, ::testing::Not(HasSubstr("W-FIT-FREEDOM")));
}

// The log begins at 20 degC as far as a sensor can tell.
TEST_F(Thermal, ReferencesThatNoLogSawAreNamed) {
  ASSERT_EQ(run({"simulate", "drift", job_, "--errors", "hidden.toml", "--seed", "2"}).exit, 0);
  EXPECT_THAT(run({"fit", job_}).err, ::testing::Not(HasSubstr("the reference")));
  std::ifstream in(job_);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const std::string section = "[thermal]\n";
  text.insert(text.find(section) + section.size(), "reference = 19\n");
  EXPECT_THAT(run({"fit", folder_.put("cold.toml", text)}).err,
              HasSubstr("the reference 19 degC is outside"));
}

TEST_F(Thermal, WarmWorkpiecesAreCutLarger) {
  const auto x_of = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"predict", "mill.toml", "--at", "X=100,Y=0,Z=0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return ask(arguments)["points"][0]["deviation"]["position_mm"][0].get<double>();
  };
  EXPECT_NEAR(x_of({"--workpiece-temperature", "30", "--workpiece-ppm", "11.5"}), -11.5e-3, 1e-6);
  EXPECT_NEAR(x_of({"--workpiece-temperature", "10", "--workpiece-ppm", "11.5"}), 11.5e-3, 1e-6);
  EXPECT_EQ(x_of({}), 0);
  const std::string part =
      folder_.put("part.ngc", "G21 G90 G94\nT1 M6\nG43 H1\nG0 X0 Y0 Z50\nG1 F500 Z0\nX200\nM2\n");
  folder_.put("t.tbl", "T1 P1 Z100.000 D10 ; gauge=100.000\n");
  const std::vector<std::string> compensate = {
      "compensate", "mill.toml",         part,      "-o",    folder_ / "out.ngc",
      "--offset",   "G54=X10,Y20,Z-250", "--tools", "t.tbl", "--workpiece-temperature",
      "30",         "--workpiece-ppm",   "11.5"};
  const ProgramRun done = run(compensate);
  ASSERT_EQ(done.exit, 0) << done.err;
  std::ifstream file(folder_ / "out.ngc");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("X200.023"));  // 200 mm * 11.5e-6 * 10
  EXPECT_THAT(text.str(), HasSubstr("(ABBE WORKPIECE DEGC = 30)"));
  EXPECT_THAT(text.str(), HasSubstr("(ABBE WORKPIECE PPM/K = 11.5)"));
  std::vector<std::string> ideal = compensate;
  ideal.insert(ideal.end(), {"--datum", "ideal"});
  const ProgramRun refused = run(ideal);
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("E-EXPANSION"));
  EXPECT_EQ(run({"predict", "mill.toml", "--at", "X=0,Y=0,Z=0", "--workpiece-ppm", "11.5"}).exit, 2);
  const auto exit_with = [&](const char* ppm) {
    return run({"predict", "mill.toml", "--at", "X=0,Y=0,Z=0", "--workpiece-ppm", ppm,
                "--workpiece-temperature", "30"})
        .exit;
  };
  for (const char* wrong : {"11500", "1.15e-5", "0.0115", "-11.5", "nan"})
    EXPECT_EQ(exit_with(wrong), 2) << wrong;
  for (const char* right : {"0", "0.6", "23"}) EXPECT_EQ(exit_with(right), 0) << right;
}

TEST_F(Thermal, WarmWorkpiecesOfTurningTools) {
  // B carries the tool: no errors of the chain can say it, but poses and predictions can.
  folder_.put(
      "five.toml",
      "format = 1\n[machine]\nname = \"five\"\nchain = \"w C b X Y Z B t\"\n[axis.C]\ndirection = [0, 0, "
      "1]\n[axis.B]\ndirection = [0, 1, 0]\norigin = [0, 0, 400]\n[tool]\norigin = [0, 0, 400]\nlength = "
      "100\n[errors]\nEC0Y = 10\n");
  const std::vector<std::string> warm = {"--workpiece-temperature", "30", "--workpiece-ppm", "11.5"};
  const auto answer = [&](std::vector<std::string> arguments, bool is_warm) {
    if (is_warm) arguments.insert(arguments.end(), warm.begin(), warm.end());
    return ask(std::move(arguments))["points"][0];
  };
  const std::vector<std::string> predict = {"predict", "five.toml", "--at", "X=100,Y=0,Z=0,B=30,C=20"};
  const json cold_point = answer(predict, false), warm_point = answer(predict, true);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(warm_point["deviation"]["position_mm"][k].get<double>() -
                    cold_point["deviation"]["position_mm"][k].get<double>(),
                -115e-6 * cold_point["nominal"]["position_mm"][k].get<double>(), 1e-9);
  // What the poses of a warm part ask for is what poses 115 ppm further out ask for.
  folder_.put("d.csv",
              "gear_static_x_um,gear_static_y_um,gear_static_z_um,gear_static_a_urad,gear_static_b_urad,"
              "gear_static_c_urad\n10,0,-5,0,20,0\n");
  for (const std::vector<std::string>& verb : {std::vector<std::string>{"inverse", "five.toml"},
                                               {"cl-correct", "five.toml", "--deviations", "d.csv"}}) {
    const auto q_of = [&](const char* pose, bool is_warm) {
      std::vector<std::string> arguments = verb;
      arguments.insert(arguments.end(), {"--pose", pose});
      return answer(arguments, is_warm)["q"];
    };
    const json of_warm = q_of("100,50,20,0.5,0,0.8660254", true),
               of_scaled = q_of("100.0115,50.00575,20.0023,0.5,0,0.8660254", false);
    for (const char* axis : {"X", "Y", "Z", "B", "C"})
      EXPECT_NEAR(of_warm[axis].get<double>(), of_scaled[axis].get<double>(), 1e-9) << verb[0] << axis;
  }
  // As a program: from CSV, with its head saying so; CL data are not scaled.
  folder_.put("poses.csv", "x,y,z,i,j,k\n0,0,50,0,0,1\n100,50,20,0.5,0,0.8660254\n");
  std::vector<std::string> emit = {"inverse", "five.toml", "--poses", "poses.csv", "--emit",
                                   "gcode",   "--feed",    "500",     "-o",        "out.ngc"};
  emit.insert(emit.end(), warm.begin(), warm.end());
  const ProgramRun program = run(emit);
  ASSERT_EQ(program.exit, 0) << program.err;
  std::ifstream file(folder_ / "out.ngc");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("(ABBE WORKPIECE DEGC = 30)"));
  folder_.put("part.cls", "UNITS/MM\nMULTAX/ON\nFEDRAT/500,MMPM\nGOTO/0,0,50,0,0,1\nFINI\n");
  emit[3] = "part.cls";
  EXPECT_THAT(run(emit).err, HasSubstr("E-EXPANSION"));
  EXPECT_EQ(run({"inverse", "five.toml", "--pose", "1,2,3,0,0,1", "--workpiece-ppm", "11.5"}).exit, 2);
}

}  // namespace
}  // namespace abbe::cli
