// `abbe toolpath`, `machine` and `inspect`: closed forms on plane, cylinder and sphere, JSON, wrong input.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr double kDigits = 1.2e-4;  // mm: rounding of the program, a few digits of 0.1 um

const std::string kMill = R"(format = 1
[machine]
name = "mill"
chain = "w X b Y Z t"
[axis.X]
errors_seen = "tool"
[axis.Y]
[axis.Z]
[tool]
origin = [0, 0, 300]
length = 100
)";

const std::string kPlane = R"(format = 1
[surface]
name = "slope"
degree = [1, 1]
points = [[[0, 0, 0], [0, 20, 0]], [[40, 0, 8], [40, 20, 8]]]
)";

class Parts : public ::testing::Test {
 protected:
  /// Tool path and part on a machine with these errors; the answer of `machine`.
  json cut(const std::string& surface, const std::string& errors, std::vector<std::string> options = {}) {
    const std::string machine = folder_.put("mill.toml", kMill + errors),
                      part = folder_.put("part.toml", surface);
    const ProgramRun path = run(
        {"toolpath", part, "--scallop-um", "5", "-o", folder_ / "part.ngc", "--cl", folder_ / "part.cls"});
    EXPECT_EQ(path.exit, 0) << path.err;
    std::vector<std::string> all{
        "machine",         machine,   folder_ / "part.ngc", "--surface", part, "--offset",
        "G54=X0,Y0,Z-200", "--start", "X0,Y0,Z0",           "--json",    "-o", folder_ / "points.csv"};
    all.insert(all.end(), options.begin(), options.end());
    const ProgramRun made = run(all);
    EXPECT_EQ(made.exit, 0) << made.err;
    return made.exit == 0 ? json::parse(made.out) : json();
  }
  ProgramRun run(const std::vector<std::string>& words) { return run_abbe(words, {}, folder_.path()); }
  std::string code(const std::vector<std::string>& words, int exit = 2) {
    const ProgramRun is = run(words);
    EXPECT_EQ(is.exit, exit) << is.err;
    const std::size_t at = is.err.find('[');
    return at == std::string::npos ? "" : is.err.substr(at + 1, is.err.find(']') - at - 1);
  }
  Folder folder_;
};

TEST_F(Parts, APerfectMachineLeavesScallopsOnly) {
  const json is = cut(kPlane, "");
  EXPECT_EQ(is["verb"], "machine");
  EXPECT_EQ(is["points"].size(), 100u);
  EXPECT_GE(is["deviation"]["least_mm"], -kDigits);
  EXPECT_LE(is["deviation"]["most_mm"], 0.005 + kDigits);
  EXPECT_GT(is["deviation"]["most_mm"], 0.003);
}

TEST_F(Parts, SquarenessShearsTheSlope) {
  // EB0Z = 500 urad tilts Z towards +X: x = 5e-4 z at the height z over the datum, so the slope of 1 in 5 is
  // shifted: deviation = n . (5e-4 z, 0, 0), n = (-1, 0, 5) / sqrt(26)
  const json perfect = cut(kPlane, ""), sheared = cut(kPlane, "[errors]\nEB0Z = 500\n");
  for (std::size_t k = 0; k < 100; ++k) {
    const double z = perfect["points"][k]["nominal_mm"][2];
    const double more = sheared["points"][k]["deviation_mm"].get<double>() -
                        perfect["points"][k]["deviation_mm"].get<double>();
    // The tip stands where the tool does: z of the tip, not of the contact, counts (0.058 mm higher here).
    EXPECT_NEAR(more, -5e-4 * z / std::sqrt(26.0), 3e-4) << k;
  }
  const double low = sheared["points"][0]["deviation_mm"], high = sheared["points"][95]["deviation_mm"];
  EXPECT_LT(high, low - 4e-4) << "material is missing where Z is high";
}

TEST_F(Parts, SmallErrorsAddUp) {
  const std::string a = "EZX = { poly = [0, 0.2] }\n", b = "EYY = { poly = [0, 0.3] }\nEXZ = 4\n";
  const json none = cut(kPlane, ""), first = cut(kPlane, "[errors]\n" + a),
             second = cut(kPlane, "[errors]\n" + b), both = cut(kPlane, "[errors]\n" + a + b);
  const auto at = [](const json& j, std::size_t k) { return j["points"][k]["deviation_mm"].get<double>(); };
  for (std::size_t k = 0; k < 100; ++k)
    EXPECT_NEAR(at(both, k) - at(none, k), at(first, k) + at(second, k) - 2 * at(none, k), 5e-5) << k;
}

TEST_F(Parts, CompensationTakesTheErrorsAway) {
  const std::string errors = "[errors]\nEZX = { poly = [0, 0.5] }\nEYY = { poly = [0, 0.3] }\nEB0Z = 100\n";
  const json before = cut(kPlane, errors), perfect = cut(kPlane, errors, {"--ideal"});
  const ProgramRun done = run({"compensate", folder_ / "mill.toml", folder_ / "part.ngc", "-o",
                               folder_ / "c.ngc", "--offset", "G54=X0,Y0,Z-200", "--start", "X0,Y0,Z0"});
  ASSERT_EQ(done.exit, 0) << done.err;
  const ProgramRun after =
      run({"machine", folder_ / "mill.toml", folder_ / "c.ngc", "--surface", folder_ / "part.toml",
           "--offset", "G54=X0,Y0,Z-200", "--start", "X0,Y0,Z0", "--json"});
  ASSERT_EQ(after.exit, 0) << after.err;
  EXPECT_GT(before["deviation"]["most_mm"], 0.012);
  const json is = json::parse(after.out);
  for (std::size_t k = 0; k < 100; ++k)
    EXPECT_NEAR(is["points"][k]["deviation_mm"].get<double>(),
                perfect["points"][k]["deviation_mm"].get<double>(), 5e-4)
        << k;
}

TEST_F(Parts, WearLeavesMaterialAndNoiseRepeats) {
  const json sharp = cut(kPlane, ""), worn = cut(kPlane, "", {"--worn-um", "4"});
  EXPECT_NEAR(worn["deviation"]["least_mm"].get<double>() - sharp["deviation"]["least_mm"].get<double>(),
              0.004, 2e-5);
  const json noisy = cut(kPlane, "", {"--noise-um", "2", "--seed", "5"}),
             again = cut(kPlane, "", {"--noise-um", "2", "--seed", "5"});
  EXPECT_EQ(noisy["points"], again["points"]);
  EXPECT_NE(noisy["points"], sharp["points"]);
  EXPECT_LT(noisy["deviation"]["least_mm"], sharp["deviation"]["least_mm"]);
}

TEST_F(Parts, InspectReadsWhatMachineWrites) {
  const json made = cut(kPlane, "[errors]\nEZX = { poly = [0, 0.2] }\n");
  const std::vector<std::string> inspect{"inspect", folder_ / "part.toml", folder_ / "points.csv", "--json"};
  const ProgramRun none = run(inspect);
  ASSERT_EQ(none.exit, 0) << none.err;
  const json is = json::parse(none.out);
  EXPECT_NEAR(is["deviation"]["profile_mm"], made["deviation"]["profile_mm"], 1e-6);
  EXPECT_NEAR(is["deviation"]["linear_mm"], made["deviation"]["linear_mm"], 1e-6);
  std::vector<std::string> fitted = inspect;
  fitted.insert(fitted.end(), {"--fit", "rigid", "--svg", folder_ / "map.svg", "--csv", folder_ / "out.csv"});
  const ProgramRun rigid = run(fitted);
  ASSERT_EQ(rigid.exit, 0) << rigid.err;
  const json fit = json::parse(rigid.out);
  EXPECT_EQ(fit["fit"]["rank"], 3) << "a plane";
  EXPECT_LT(fit["deviation"]["profile_mm"], 0.006) << "the tilt is fitted away, the scallops stay";
  EXPECT_TRUE(std::ifstream(folder_ / "map.svg").good());
}

TEST_F(Parts, PointsOfAMeasuringMachineAreRead) {
  const std::string part = folder_.put("part.toml", kPlane);
  const std::string points =
      folder_.put("cmm.csv", "id,mx,my,mz\n1,10,5,2.01\n2,20,10,4.01\n3,30,15,6.01\n4,15,18,3.01\n");
  const ProgramRun is = run({"inspect", part, points, "--columns", "mx,my,mz", "--json"});
  ASSERT_EQ(is.exit, 0) << is.err;
  EXPECT_NEAR(json::parse(is.out)["deviation"]["mean_mm"], 0.01 * 5 / std::sqrt(26.0), 1e-9);
  const ProgramRun ball =
      run({"inspect", part, points, "--columns", "mx,my,mz", "--probe-radius-mm", "0.005", "--json"});
  EXPECT_NEAR(json::parse(ball.out)["deviation"]["mean_mm"], 0.01 * 5 / std::sqrt(26.0) - 0.005, 1e-9);
  EXPECT_EQ(run({"inspect", part, points, "--columns", "mx,my,mz", "--limit-um", "5", "--strict"}).exit, 4);
}

TEST_F(Parts, AMeasuringMachineMayBeWrong) {
  const std::string part = folder_.put("part.toml", kPlane),
                    points = folder_.put("cmm.csv", "x,y,z\n10,5,2\n20,10,4\n30,15,6\n15,18,3\n");
  const auto mean = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"inspect", part, points, "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return json::parse(run(words).out)["deviation"]["mean_mm"].get<double>();
  };
  EXPECT_NEAR(mean({}), 0, 1e-12);
  EXPECT_NEAR(mean({"--probe-size-um", "4"}), 0.004, 1e-12);
  // The slope goes through the origin, so that a scale moves its points within it; not those above it.
  EXPECT_NEAR(mean({"--probe-scale-ppm", "100"}), 0, 1e-12);
  folder_.put("cmm.csv", "x,y,z\n10,5,3\n");
  EXPECT_NEAR(mean({"--probe-scale-ppm", "100"}), 5 / std::sqrt(26.0) * 1.0001, 1e-9);
}

TEST_F(Parts, MeasuredPointsOfOthersAreRead) {
  const std::string file = ABBE_SOURCE_DIR "/../shared/data/metrology/robot-WAM-random.csv";
  if (!std::ifstream(file)) GTEST_SKIP() << file << " is not there";
  const std::string plane =
      folder_.put("plane.toml",
                  "format = 1\n[surface]\ndegree = [1, 1]\npoints = [[[-2000, -2000, 0], "
                  "[-2000, 2000, 0]], [[2000, -2000, 0], [2000, 2000, 0]]]\n");
  const ProgramRun is = run({"inspect", plane, file, "--columns", "x_t,y_t,z_t", "--json"});
  ASSERT_EQ(is.exit, 0) << is.err;
  const json answer = json::parse(is.out);
  EXPECT_EQ(answer["points"].size(), 20u);
  for (const json& point : answer["points"])
    EXPECT_NEAR(point["deviation_mm"].get<double>(), point["measured_mm"][2].get<double>(), 1e-9);
}

TEST_F(Parts, CreasesAndPolesAreSaid) {
  const std::string roof =
                        folder_.put("roof.toml",
                                    "format = 1\n[surface]\ndegree = [1, 1]\npoints = [[[-10, 0, -10], [-10, "
                                    "20, -10]], [[0, 0, 0], [0, 20, 0]], [[10, 0, -10], [10, 20, -10]]]\n"),
                    cone = folder_.put("cone.toml",
                                       "format = 1\n[surface]\ndegree = [1, 1]\npoints = [[[0, 0, 0], [0, 0, "
                                       "0]], [[10, 0, 5], [0, 10, 5]]]\n");
  EXPECT_EQ(code({"inspect", roof, folder_.put("top.csv", "x,y,z\n0.1,5,0.3\n"), "--strict"}, 4),
            "W-PART-CREASE");
  EXPECT_EQ(code({"toolpath", cone}), "E-PATH-POLE");
}

TEST_F(Parts, InterruptLeavesNothingBehind) {
  std::string rows = "x,y,z\n";
  for (int k = 0; k < 300000; ++k) rows += "10,5,2.1\n";
  const std::string part = folder_.put("part.toml", kPlane), points = folder_.put("long.csv", rows);
  EXPECT_EQ(interrupt_abbe({"inspect", part, points, "--csv", folder_ / "out.csv"}), 130);
  EXPECT_FALSE(std::ifstream(folder_ / "out.csv"));
}

TEST_F(Parts, PointsBesideThePatchDoNotPass) {
  const std::string part = folder_.put("part.toml", kPlane),
                    far = folder_.put("far.csv", "x,y,z\n200,200,3\n");
  const ProgramRun is = run({"inspect", part, far, "--limit-um", "5", "--json"});
  ASSERT_EQ(is.exit, 0) << is.err;
  EXPECT_FALSE(json::parse(is.out)["pass"]);
  EXPECT_THAT(run({"inspect", part, far, "--limit-um", "5"}).out, HasSubstr("fail"));
}

TEST_F(Parts, WhatTheMachineCannotDoIsSaid) {
  cut(kPlane, "");
  const auto warned = [&](const std::vector<std::string>& more, int exit = 4) {
    std::vector<std::string> words{"machine",
                                   folder_ / "mill.toml",
                                   folder_ / "part.ngc",
                                   "--surface",
                                   folder_ / "part.toml",
                                   "--start",
                                   "X0,Y0,Z0",
                                   "--strict"};
    words.insert(words.end(), more.begin(), more.end());
    return code(words, exit);
  };
  EXPECT_EQ(warned({"--offset", "G54=X0,Y0,Z-200", "--cutter", "ball:1", "--reach-mm", "0.01"}),
            "W-PART-UNCUT");
  EXPECT_EQ(warned({"--offset", "G54=X0,Y0,Z-200", "--cutter", "flat:6", "--reach-mm", "0.01"}),
            "W-PART-GOUGE");
  std::string small = kMill;
  small.replace(small.find("[axis.Y]"), 8, "[axis.Y]\nrange = [-5, 5]");
  folder_.put("mill.toml", small);
  EXPECT_EQ(warned({"--offset", "G54=X0,Y0,Z-200"}, 5), "W-PART-TRAVEL");
  folder_.put("mill.toml", kMill + "[errors]\nEXX = { table = [[-1, 0], [3, 1]] }\n");
  EXPECT_EQ(warned({"--offset", "G54=X0,Y0,Z-200"}, 5), "W-PART-VOLUME");
  const ProgramRun answered =
      run({"machine", folder_ / "mill.toml", folder_ / "part.ngc", "--surface", folder_ / "part.toml",
           "--start", "X0,Y0,Z0", "--offset", "G54=X0,Y0,Z-200"});
  EXPECT_EQ(answered.exit, 5);
  EXPECT_THAT(answered.out, HasSubstr("profile")) << "answered all the same";
}

TEST_F(Parts, ProgramsThatCannotBeFollowedAreNamed) {
  const std::string part = folder_.put("part.toml", kPlane);
  const auto followed = [&](const std::string& machine, const std::string& program,
                            const std::vector<std::string>& more, int exit) {
    std::vector<std::string> words{"machine",
                                   folder_.put("m.toml", machine),
                                   folder_.put("a.ngc", program),
                                   "--surface",
                                   part,
                                   "--offset",
                                   "G54=X0,Y0,Z-200",
                                   "--start",
                                   "X0,Y0,Z0",
                                   "--tool-change",
                                   "keeps"};
    words.insert(words.end(), more.begin(), more.end());
    return code(words, exit);
  };
  const std::string head = "G21 G90 G54\nG0 X0 Y0 Z5\n";
  EXPECT_EQ(followed(kMill, head + "T1 M6\nG1 Z0 F100\nT2 M6\nG1 X5\nM2\n",
                     {"--gauge", "T1=100", "--gauge", "T2=100"}, 3),
            "E-PART-TOOL");
  EXPECT_EQ(followed(kMill, head + "G95 G1 Z0 F0.1\nM2\n", {"--clock"}, 3), "E-PART-TIME");
  std::string askew = kMill;
  askew.replace(askew.find("[axis.Y]"), 8, "[axis.Y]\ndirection = [0.001, 1, 0]");
  EXPECT_EQ(followed(askew, head + "G1 Z0 F100\nM2\n", {}, 3), "E-PART-AXES");
}

TEST_F(Parts, MoreWayThanMemoryIsRefused) {
  // Full circles of R = 1000 mm at a tolerance of 10 nm: 15708 poses each, which all reach the points.
  std::string circles = "G21 G90 G54\nG0 X0 Y0 Z5\nG1 Z0 F100\n";
  for (int k = 0; k < 60; ++k) circles += "G2 X0 Y0 I1000 J0\n";
  EXPECT_EQ(code({"machine", folder_.put("mill.toml", kMill), folder_.put("a.ngc", circles + "M2\n"),
                  "--surface", folder_.put("part.toml", kPlane), "--offset", "G54=X0,Y0,Z-200", "--start",
                  "X0,Y0,Z0", "--cutter-length", "3000"}),
            "E-PART-SIZE");
}

TEST_F(Parts, ClDataOfAPathAreRead) {
  cut(kPlane, "");
  const ProgramRun is = run({"compensate", folder_ / "mill.toml", folder_ / "part.cls", "-o",
                             folder_ / "c.cls", "--offset", "G54=X0,Y0,Z-200", "--start", "X0,Y0,Z0"});
  EXPECT_EQ(is.exit, 0) << is.err;
}

TEST_F(Parts, MistakesAreNamed) {
  const std::string part = folder_.put("part.toml", kPlane), mill = folder_.put("mill.toml", kMill);
  const std::string hollow = folder_.put("hollow.toml",
                                         "format = 1\n[surface]\ndegree = [2, 1]\npoints = [[[-2, 0, 2], "
                                         "[-2, 9, 2]], [[0, 0, -2], [0, 9, -2]], [[2, 0, 2], [2, 9, 2]]]\n");
  const std::string program = folder_.put("a.ngc", "G21 G90 G54\nG0 X0 Y0 Z5\nG1 Z0 F100\nG1 X5\nM2\n");
  const std::string no_y = folder_.put(
      "no_y.toml", "format = 1\n[machine]\nname = \"m\"\nchain = \"w X b Z t\"\n[axis.X]\n[axis.Z]\n");
  EXPECT_EQ(code({"toolpath", hollow}), "E-PATH-CURVATURE");
  EXPECT_EQ(code({"toolpath", folder_.put("under.toml", kPlane + "outward = \"v x u\"\n")}),
            "E-PATH-UNDERCUT");
  EXPECT_EQ(code({"toolpath", part, "--step-mm", "0.001"}), "E-PATH-ENDLESS");
  EXPECT_EQ(code({"toolpath", part, "--cutter", "flat:3"}), "E-OPTION");
  EXPECT_EQ(code({"machine", mill, program, "--surface", part, "--cutter", "bull:3"}), "E-OPTION");
  EXPECT_EQ(code({"machine", mill, program, "--surface", part, "--grid", "10"}), "E-OPTION");
  EXPECT_EQ(code({"machine", mill, program, "--surface", part, "--report", "r.json"}), "E-OPTION");
  EXPECT_EQ(code({"machine", mill, program, "--surface", "none.toml"}), "E-FILE");
  EXPECT_EQ(
      code({"machine", no_y, program, "--surface", part, "--offset", "G54=X0,Y0,Z0", "--start", "X0,Y0,Z0"},
           3),
      "E-AXIS");
  EXPECT_EQ(code({"inspect", part, folder_.put("p.csv", "a,b,c\n1,2,3\n")}), "E-COLUMN");
  EXPECT_EQ(code({"inspect", part, folder_.put("p2.csv", "x,y,z\n1,2,3\n"), "--target-columns", "a,b,c"}),
            "E-COLUMN");
  EXPECT_EQ(code({"inspect", part, folder_.put("q.csv", "x,y,z\n1,,3\n")}), "E-CELL");
  EXPECT_EQ(code({"inspect", part, folder_.put("r.csv", "x,y,z\n")}), "E-CSV");
  EXPECT_EQ(code({"inspect", part, folder_.put("s.csv", "x,y,z\n90,9,1\n10,5,2\n"), "--strict"}, 4),
            "W-PART-BESIDE");
}

}  // namespace
}  // namespace abbe::cli
