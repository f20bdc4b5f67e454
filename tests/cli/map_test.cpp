// `abbe map`: the members of its JSON, the CSV as points of predict, limits, wrong volumes, interrupts.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "machines.h"
#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kRounding = 1e-9;  // um

class Map : public ::testing::Test {
 protected:
  ProgramRun map(std::vector<std::string> options, const std::string& machine) {
    options.insert(options.begin(), {"map", machine});
    return run_abbe(options, {}, folder_.path());
  }
  ProgramRun map(std::vector<std::string> options) {
    options.insert(options.end(), {"--set", "T1=23"});
    return map(std::move(options), three_);
  }
  static std::string content(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  Folder folder_;
  std::string three_ = folder_.put("three.toml", kThreeAxes);
  std::string five_ = folder_.put("five.toml", kFiveAxes);
};

// EXX 0.1 um/mm seen at the tool, EYY 5 um, TZZ 2 um/degC: dx = 0.1 x, dy = 5, dz = 6.
TEST_F(Map, JsonIsWhatIsWorkedOutInTheHead) {
  const ProgramRun run = map({"--json"});
  ASSERT_EQ(run.exit, 0) << run.err;
  const json read = json::parse(run.out);
  EXPECT_EQ(read["verb"], "map");
  EXPECT_EQ(read["format"], 1);
  EXPECT_EQ(read["model"], "rigid");
  EXPECT_EQ(read["volume"]["points"], 9261);
  EXPECT_EQ(read["volume"]["positions"]["Y"].size(), 21U);
  EXPECT_EQ(read["volume"]["positions"]["Y"].back(), 250.0);
  const json& d = read["deviation"];
  EXPECT_NEAR(d["x"]["min_um"], -40, kRounding);
  EXPECT_NEAR(d["x"]["max_um"], 40, kRounding);
  EXPECT_NEAR(d["x"]["rms_um"], 40 * std::sqrt(22.0 / 60), kRounding);  // of 21 even positions: (n+1)/3(n-1)
  EXPECT_NEAR(d["x"]["percentile95_um"], 40, kRounding);                // 2 of 21 columns are at the ends
  EXPECT_EQ(d["x"]["max_at"]["X"], 400.0);
  EXPECT_NEAR(d["y"]["mean_um"], 5, kRounding);
  EXPECT_NEAR(d["z"]["range_um"], 0, kRounding);
  EXPECT_NEAR(d["distance"]["max_um"], std::sqrt(1600.0 + 25 + 36), kRounding);
  EXPECT_EQ(read["tilt"]["max_rad"], 0.0);
  EXPECT_NEAR(read["from_datum"]["distance"]["max_um"], 40, kRounding);
  EXPECT_NEAR(read["from_datum"]["datum_deviation_um"][2], 6, kRounding);
  EXPECT_NEAR(read["best_fit"]["translation_um"][1], 5, kRounding);
  const json& v = read["volumetric_accuracy"];
  EXPECT_EQ(v["name"], "V_XYZ");
  EXPECT_THAT(v["definition"].get<std::string>(), HasSubstr("ISO 230-1"));
  EXPECT_NEAR(v["as_stated"]["position_um"][0], 80, kRounding);
  EXPECT_NEAR(v["as_stated"]["position_um"][1], 0, kRounding);
  EXPECT_EQ(v["as_stated"]["orientation_rad"].size(), 3U);
  ASSERT_EQ(read["diagonals"].size(), 10U);
  const json& xy = read["diagonals"][0];
  EXPECT_EQ(xy["name"], "+X +Y");
  EXPECT_NEAR(xy["length_mm"], std::hypot(800, 500), 1e-9);
  EXPECT_NEAR(xy["change_um"], 80 * 800 / std::hypot(800, 500), kRounding);
  EXPECT_EQ(xy["forward_um"].size(), xy["s_mm"].size());
  ASSERT_EQ(read["budget"].size(), 3U);
  EXPECT_EQ(read["budget"][0]["error"], "EXX");
  EXPECT_EQ(read["budget"][1]["error"], "TZZ");
  EXPECT_NEAR(read["budget"][1]["rms_um"], 6, kRounding);
  EXPECT_NEAR(read["budget"][1]["rms_without_um"], std::hypot(d["x"]["rms_um"].get<double>(), 5), kRounding);
  EXPECT_TRUE(read["lost_motion"].empty());
  EXPECT_TRUE(read["extrapolated"].empty());
  EXPECT_FALSE(read.contains("pass"));
}

TEST_F(Map, NumberOfThreadsChangesNoByte) {
  const std::string one = map({"--json", "--threads", "1"}).out;
  EXPECT_EQ(map({"--json", "--threads", "4"}).out, one);
  EXPECT_EQ(map({"--json"}).out, one);
}

TEST_F(Map, TextShowsDefinitionsAndPlaces) {
  const ProgramRun run = map({"--limit-um", "30", "--most", "1"});
  ASSERT_EQ(run.exit, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("ISO 230-1"));
  EXPECT_THAT(run.out, HasSubstr("ISO 230-6"));
  EXPECT_THAT(run.out, HasSubstr("95 %: the smallest value"));
  EXPECT_THAT(run.out, HasSubstr("largest at X -400  Y -250  Z -300"));
  EXPECT_THAT(run.out, HasSubstr("and 2 smaller ones"));
  EXPECT_THAT(run.out, HasSubstr("FAIL: "));
  EXPECT_EQ(run.err, "");
}

TEST_F(Map, LimitsEndAsInPredict) {
  EXPECT_EQ(map({"--limit-um", "41"}).exit, 0);
  EXPECT_THAT(map({"--limit-um", "41"}).out, HasSubstr("pass: 9261 of 9261"));
  EXPECT_EQ(map({"--limit-um", "41", "--strict"}).exit, 0);
  EXPECT_EQ(map({"--limit-um", "40"}).exit, 0);
  EXPECT_EQ(map({"--limit-um", "40", "--strict"}).exit, 4);
  EXPECT_EQ(map({"--limit-angle-deg", "0", "--strict"}).exit, 0);
  const json read = json::parse(map({"--limit-um", "20", "--json"}).out);
  EXPECT_EQ(read["pass"], false);
  EXPECT_EQ(read["points_within"], 9 * 441);  // 0.1 x within sqrt(400 - 61) = 18.4 um: 9 of 21 columns
}

TEST_F(Map, VolumesOfAllKinds) {
  const json held = json::parse(map({"--json", "--at", "X=7", "--count", "5"}).out);
  EXPECT_EQ(held["volume"]["points"], 25);
  EXPECT_EQ(held["volume"]["positions"]["X"], json::parse("[7]"));
  EXPECT_EQ(held["diagonals"].size(), 2U);
  EXPECT_EQ(held["volumetric_accuracy"]["name"], "V_YZ");
  const json mixed = json::parse(map({"--json", "--range", "X=-100:100:5", "--positions", "Y=50/-50/0",
                                      "--count", "Z=3", "--datum-at", "X=50"})
                                     .out);
  EXPECT_EQ(mixed["volume"]["points"], 45);
  EXPECT_EQ(mixed["volume"]["positions"]["X"], json::parse("[-100, -50, 0, 50, 100]"));
  EXPECT_EQ(mixed["volume"]["positions"]["Y"], json::parse("[-50, 0, 50]"));
  EXPECT_EQ(mixed["from_datum"]["datum"]["X"], 50.0);
  EXPECT_NEAR(mixed["from_datum"]["datum_deviation_um"][0], 5, kRounding);
  const json beyond = json::parse(map({"--json", "--range", "X=0:500"}).out);
  EXPECT_THAT(beyond["outside_travel"], ElementsAre("X"));
  const ProgramRun turning = map({"--json", "--range", "C=0:360:5", "--count", "3"}, five_);
  ASSERT_EQ(turning.exit, 2);  // Y and Z of this machine have no travel
  const ProgramRun five = map({"--json", "--range", "C=0:360:5,Y=-200:200,Z=0:100", "--count", "3"}, five_);
  ASSERT_EQ(five.exit, 0) << five.err;
  const json read = json::parse(five.out);
  EXPECT_EQ(read["volume"]["points"], 5 * 81);
  EXPECT_EQ(read["volume"]["positions"]["C"].back(), 360.0);
  EXPECT_EQ(read["volumetric_accuracy"]["name"], "V_XYZAC");
}

TEST_F(Map, CsvIsAlsoAFileOfPoints) {
  const std::string csv = folder_ / "map.csv";
  const ProgramRun run =
      map({"--csv", csv, "--range", "C=0:360:4,Y=-200:200:2,Z=0:100:2", "--count", "2"}, five_);
  ASSERT_EQ(run.exit, 0) << run.err;
  std::istringstream lines(content(csv));
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(line, "C,X,Y,Z,A,dx_um,dy_um,dz_um,distance_um,ex_urad,ey_urad,ez_urad,tilt_urad,extrapolated");
  const ProgramRun predicted = run_abbe({"predict", five_, "--points", csv, "--json"});
  ASSERT_EQ(predicted.exit, 0) << predicted.err;
  const json points = json::parse(predicted.out)["points"];
  ASSERT_EQ(points.size(), 64U);
  for (const json& point : points) {
    ASSERT_TRUE(std::getline(lines, line));
    std::istringstream cells(line);
    std::vector<double> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    ASSERT_EQ(row.size(), 14U);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(row[5 + c], point["deviation"]["position_mm"][c].get<double>() * 1e3, kRounding);
    EXPECT_NEAR(row[8], std::hypot(row[5], row[6], row[7]), kRounding);
    EXPECT_EQ(row[13], 0);
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(Map, SvgIsWritten) {
  const std::string svg = folder_ / "map.svg";
  ASSERT_EQ(map({"--svg", svg}).exit, 0);
  EXPECT_THAT(content(svg), HasSubstr("three axes: deviation over the volume"));
  EXPECT_THAT(content(svg), HasSubstr("</svg>"));
}

TEST_F(Map, WrongVolumesAreNamed) {
  const auto refused = [&](std::vector<std::string> options, const char* message) {
    const std::string given = options.front() + " " + options.back();
    const ProgramRun run = map(std::move(options));
    EXPECT_EQ(run.exit, 2) << given;
    EXPECT_EQ(run.out, "") << given;
    EXPECT_THAT(run.err, HasSubstr(message)) << given;
  };
  refused({"--range", "Q=0:1"}, "no moving axis 'Q'");
  refused({"--range", "X=0"}, "not of the form X=FROM:TO");
  refused({"--range", "X=0:1:2:3"}, "not of the form X=FROM:TO");
  refused({"--range", "X=5:1"}, "does not increase");
  refused({"--range", "X=0:nan"}, "not a number");
  refused({"--range", "X=0:1:0"}, "not a number of positions");
  refused({"--range", "X=0:1:2.5"}, "not a number of positions");
  refused({"--range", "X"}, "not of the form NAME=VALUE");
  refused({"--range", "X=0:1", "--at", "X=0"}, "also given with --range");
  refused({"--range", "X=0:1:5", "--count", "X=7"}, "also given with --range");
  refused({"--positions", "X=0//2"}, "not a number");
  refused({"--positions", "X=0/2/0"}, "names a position twice");
  refused({"--at", "X=zero"}, "not a number");
  refused({"--at", "T1=5"}, "no moving axis 'T1'");
  refused({"--count", "0"}, "not a number of positions");
  refused({"--count", "many"}, "not a number of positions");
  refused({"--count", "2000"}, "points are more than 4000000");
  refused({"--datum-at", "Q=0"}, "no moving axis 'Q'");
  refused({"--range", "X=-1e308:1e308"}, "too large");
  refused({"--threads", "0"}, "--threads");
  refused({"--most", "-1"}, "--most");
  refused({"--csv", "-"}, "standard output");
  refused({"--svg", three_}, "is an input");
  refused({"--csv", "a.out", "--svg", "a.out"}, "the same file");
  EXPECT_EQ(content(three_), kThreeAxes);
  const ProgramRun unknown = map({}, five_);
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_THAT(unknown.err, HasSubstr("the travel of 'C' is not known"));
  EXPECT_THAT(unknown.err, HasSubstr("--range C=FROM:TO (such as 0:360)"));
  const ProgramRun sensor = map({"--count", "2"}, three_);
  EXPECT_EQ(sensor.exit, 2);
  EXPECT_THAT(sensor.err, HasSubstr("E-SENSOR"));
}

TEST_F(Map, NumbersTooLargeAndFoldersThatAreMissing) {
  const std::string huge = folder_.put(
      "huge.toml",
      "format = 1\n[machine]\nchain = \"w b X t\"\n[axis.X]\nrange = [0, 1e200]\n[errors]\nEXX = { "
      "poly = [0, 0, 1e200] }\n");
  const ProgramRun run = map({}, huge);
  EXPECT_EQ(run.exit, 2);
  EXPECT_THAT(run.err, HasSubstr("E-RANGE"));
  EXPECT_NE(map({"--csv", folder_ / "absent/map.csv"}).exit, 0);
}

TEST_F(Map, InterruptLeavesNothingBehind) {
  const std::string csv = folder_.put("map.csv", "before");
  // A second or more of work begins where the program catches the signal.
  EXPECT_EQ(
      interrupt_abbe({"map", three_, "--set", "T1=20", "--threads", "1", "--count", "100", "--csv", csv}),
      130);
  EXPECT_EQ(content(csv), "before");
  const auto files = std::filesystem::directory_iterator(folder_.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 3);  // two machines and the file of before
}

}  // namespace
}  // namespace abbe::cli
