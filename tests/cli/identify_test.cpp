// `abbe simulate ballbar`, `identify`, `identifiability`: a machine with known errors is measured,
// identified, predicted.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kMill = "format = 1\n[machine]\nname = \"mill\"\nchain = \"w b X Y Z t\"\n";

class Identify : public ::testing::Test {
 protected:
  ProgramRun abbe(const std::vector<std::string>& words) { return run_abbe(words, {}, folder_.path()); }

  /// Six tests XY: two radii, three feeds. Returns their files.
  std::vector<std::string> simulate() {
    std::vector<std::string> words = {"simulate", "ballbar", hidden_, "--out", folder_ / "t", "--seed", "3"};
    std::vector<std::string> files;
    for (const char* radius : {"100", "150"})
      for (const char* feed : {"600", "2400", "4800"}) {
        words.push_back("--test");
        words.push_back(std::string("plane=XY,samples=300,setup=a,radius=") + radius + ",feed=" + feed);
        files.push_back(folder_ / ("t" + std::to_string(files.size() + 1) + ".csv"));
      }
    const ProgramRun run = abbe(words);
    EXPECT_EQ(run.exit, 0) << run.err;
    return files;
  }
  std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& files) {
    words.insert(words.end(), files.begin(), files.end());
    return words;
  }
  static std::string content(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  Folder folder_;
  std::string mill_ = folder_.put("mill.toml", kMill);
  std::string hidden_ = folder_.put("hidden.toml", kMill + R"([errors]
EC0Y = -18
EYX = { poly = [0, 0, 2e-4] }
EXX = { forward = { poly = [-1.5] }, backward = { poly = [1.5] } }
DYY = { poly = [0, -0.006], of = "a.Y" }
)");
};

TEST_F(Identify, ErrorsFileOfASimulatedMachine) {
  const std::vector<std::string> files = simulate();
  const std::string errors = folder_ / "errors.toml";
  const ProgramRun run = abbe(with({"identify", mill_, "--json", "-o", errors}, files));
  ASSERT_EQ(run.exit, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const json answer = json::parse(run.out);
  EXPECT_TRUE(answer["trusted"]);
  EXPECT_EQ(answer["runs"].size(), 12U);
  bool found = false;
  for (const json& term : answer["terms"]) {
    if (term["term"] != "EXX lost motion") continue;
    found = true;
    EXPECT_TRUE(term["identifiable"]);
    EXPECT_NEAR(term["value"], 3e-3, 5 * term["uncertainty"].get<double>());
  }
  EXPECT_TRUE(found);
  EXPECT_EQ(answer["covariance"].size(), answer["unknowns"].size());
  const ProgramRun predicted =
      abbe({"predict", mill_, "--errors", errors, "--at", "X=50,Y=80,Z=0", "--json"});
  ASSERT_EQ(predicted.exit, 0) << predicted.err;
  // EC0Y -18 urad moves the tip by +18e-6 * 80 along X.
  EXPECT_NEAR(json::parse(predicted.out)["points"][0]["deviation"]["position_mm"][0], 1.44e-3, 2e-4);
  EXPECT_THAT(content(errors), HasSubstr("[uncertainty]"));
  const ProgramRun text = abbe(with({"identify", mill_}, files));
  EXPECT_THAT(text.out, HasSubstr("they look like the noise"));
  EXPECT_THAT(text.out, HasSubstr("assumed zero"));
}

TEST_F(Identify, PaperSinusoidsAreShownAndNeverCompensated) {
  const std::vector<std::string> files = simulate();
  const std::string errors = folder_ / "paper.toml";
  const ProgramRun run = abbe({"identify", mill_, files[0], "--method", "paper", "-o", errors});
  ASSERT_EQ(run.exit, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("artefact"));
  EXPECT_THAT(content(errors), HasSubstr("scope = \"test\""));
  const ProgramRun predicted =
      abbe({"predict", mill_, "--errors", errors, "--at", "X=0,Y=0,Z=0", "--set", "t=0"});
  ASSERT_EQ(predicted.exit, 0) << predicted.err;
  EXPECT_THAT(predicted.out, HasSubstr("of one test"));
  const std::string program = folder_.put("part.ngc", "G21 G90 G54\nG1 X10 F100\nM2\n");
  const ProgramRun refused = abbe({"compensate", mill_, program, "-o", folder_ / "out.ngc", "--errors",
                                   errors, "--set", "t=0", "--offset", "G54=X0,Y0,Z0"});
  EXPECT_EQ(refused.exit, 3) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("E-SCOPE"));
  EXPECT_EQ(content(folder_ / "out.ngc"), "");
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"correct", "--at", "X=0,Y=0,Z=0"}, {"inverse", "--pose", "1,2,3,0,0,1"}}) {
    std::vector<std::string> words = command;
    words.insert(words.begin() + 1, mill_);
    words.insert(words.end(), {"--errors", errors, "--set", "t=0"});
    const ProgramRun moved = abbe(words);
    EXPECT_EQ(moved.exit, 3) << moved.err;
    EXPECT_THAT(moved.err, HasSubstr("E-SCOPE"));
    EXPECT_EQ(moved.out, "");
  }
  EXPECT_EQ(abbe({"identify", mill_, files[0], files[1], "--method", "paper"}).exit, 2);
}

// A table's errors are of either sign until the file says whose they are; the published ones are the tool's.
TEST_F(Identify, ATableHasToSayWhoseErrorsItStates) {
  const std::vector<std::string> files = simulate();
  const std::string errors = folder_ / "errors.toml";
  const auto refused = [&](const char* method, const std::string& seen) {
    const std::string table =
        folder_.put("table.toml", "format = 1\n[machine]\nchain = \"w X b Y Z t\"\n[axis.X]\n" + seen + "\n");
    const ProgramRun run = abbe({"identify", table, files[0], "--method", method, "-o", errors});
    if (run.exit == 0) return false;
    EXPECT_EQ(run.exit, 2);
    EXPECT_THAT(run.err, HasSubstr("E-ERRORS-SEEN"));
    EXPECT_EQ(content(errors), "");
    return true;
  };
  EXPECT_TRUE(refused("joint", ""));
  EXPECT_TRUE(refused("paper", ""));
  EXPECT_TRUE(refused("paper", "errors_seen = \"body\""));
  EXPECT_FALSE(refused("paper", "errors_seen = \"tool\""));
}

TEST_F(Identify, IdentifiabilityExplainsOneFeed) {
  const ProgramRun one = abbe({"identifiability", mill_, "--test", "plane=XY,radius=100,feed=2000"});
  ASSERT_EQ(one.exit, 0) << one.err;
  EXPECT_THAT(one.out, HasSubstr("another feed tells them apart"));
  EXPECT_THAT(one.out, HasSubstr("in the box of tested positions"));
  const ProgramRun two =
      abbe({"identifiability", mill_, "--json", "--test", "plane=XY,radius=100,feed=600,setup=a", "--test",
            "plane=XY,radius=150,feed=3000,setup=a"});
  ASSERT_EQ(two.exit, 0) << two.err;
  const json answer = json::parse(two.out);
  EXPECT_GT(answer["rank"], 10);
  const json& space = answer["deviation_uncertainty"];
  EXPECT_GT(space["rms_um"], 0);
  EXPECT_GT(space["worst_um"], space["rms_um"]);
  EXPECT_NEAR(std::abs(space["at_mm"]["X"].get<double>()), 150, 1);
  EXPECT_FALSE(space["at_mm"].contains("Z"));
}

TEST_F(Identify, SimulatedBusIsACapture) {
  const ProgramRun run =
      abbe({"simulate", "ballbar", hidden_, "--test", "plane=ZX,radius=50,feed=3000,directions=CW", "--lag",
            "X=1", "--bus", "--positions", "--out", folder_ / "b"});
  ASSERT_EQ(run.exit, 0) << run.err;
  EXPECT_THAT(content(folder_ / "b1.csv"), HasSubstr("x_cmd_mm"));
  EXPECT_GT(content(folder_ / "b1.pcap").size(), 100000U);
}

// From the bus alone: the capture of the test, joined by angle, gives back the positions that were recorded
// with it, and the identification what the servo sees.
TEST_F(Identify, ACaptureJoinsItsTrace) {
  const ProgramRun simulated =
      abbe({"simulate", "ballbar", hidden_, "--test", "plane=XY,radius=100,feed=3000,samples=400", "--lag",
            "X=1,Y=4", "--bus", "--positions", "--out", folder_ / "j"});
  ASSERT_EQ(simulated.exit, 0) << simulated.err;
  const std::string bus = folder_ / "bus.csv", joined = folder_ / "joined.csv", trace = folder_ / "j1.csv";
  const ProgramRun captured =
      abbe({"capture", folder_ / "j1.pcap", "--axis", "X=1001:100000/mm,Y=1002:100000/mm", "-o", bus});
  ASSERT_EQ(captured.exit, 0) << captured.err;
  const ProgramRun run = abbe({"ballbar", trace, "--bus", bus, "--out", joined});
  ASSERT_EQ(run.exit, 0) << run.err;
  const auto rows = [&](const std::string& path) {
    std::vector<std::map<std::string, std::string>> out;
    std::vector<std::string> header;
    std::istringstream text(content(path));
    for (std::string line; std::getline(text, line);) {
      if (line.empty() || line[0] == '#') continue;
      std::vector<std::string> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
      if (header.empty()) {
        header = cells;
        continue;
      }
      auto& named = out.emplace_back();
      for (std::size_t i = 0; i < header.size(); ++i) named[header[i]] = cells[i];
    }
    return out;
  };
  const auto was = rows(trace), is = rows(joined);
  ASSERT_EQ(was.size(), is.size());
  double lag = 0;
  for (std::size_t i = 0; i < was.size(); ++i) {
    for (const char* column : {"x_mm", "y_mm", "x_cmd_mm", "y_cmd_mm"})
      ASSERT_NEAR(std::stod(is[i].at(column)), std::stod(was[i].at(column)), 1e-4) << column << ' ' << i;
    lag = std::max(lag, std::abs(std::stod(is[i].at("y_mm")) - std::stod(is[i].at("y_cmd_mm"))));
  }
  EXPECT_NEAR(lag, 50 * 0.004, 0.02) << "feed 50 mm/s, 4 ms";
  const ProgramRun identified = abbe({"identify", mill_, joined, "--json", "--rotation", "0"});
  ASSERT_EQ(identified.exit, 0) << identified.err;
  EXPECT_GT(json::parse(identified.out)["runs"][0]["servo_um"], 10);

  EXPECT_THAT(abbe({"ballbar", trace, "--plane", "XY", "--bus", trace, "--out", joined + "2"}).err,
              HasSubstr("no column t_s"));
  const std::string other = folder_ / "o";
  ASSERT_EQ(
      abbe({"simulate", "ballbar", hidden_, "--test", "plane=XY,radius=50,feed=3000", "--out", other}).exit,
      0);
  const ProgramRun refused = abbe({"ballbar", other + "1.csv", "--bus", bus});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("E-JOIN"));
}

TEST_F(Identify, WrongInputIsNamed) {
  const auto refused = [&](const std::vector<std::string>& words, const char* message) {
    const ProgramRun run = abbe(words);
    EXPECT_EQ(run.exit, 2) << message;
    EXPECT_THAT(run.err, HasSubstr(message));
  };
  const std::string lathe = folder_.put("lathe.toml", "format = 1\n[machine]\nchain = \"w b X Z t\"\n");
  const std::string plan = "plane=XY,radius=100,feed=2000";
  refused({"identifiability", mill_, "--test", "plane=XY,radius=100"}, "lacks plane, radius or feed");
  refused({"identifiability", mill_, "--test", plan + ",speed=3"}, "unknown key 'speed'");
  refused({"identifiability", mill_, "--test", plan + ",samples=3"}, "out of range");
  refused({"identifiability", mill_, "--test", plan + ",directions=left"}, "directions=left");
  refused({"identifiability", mill_, "--test", plan + ",from=90,to=20"}, "'to' is not above 'from'");
  refused({"identifiability", lathe, "--test", plan}, "E-IDENTIFY");
  refused({"identifiability", mill_, "--test", plan, "--reversal-ms", "100000"},
          "fewer samples than unknowns");
  refused({"simulate", "ballbar", lathe, "--test", plan, "--out", folder_ / "x"}, "no linear axis Y");
  const std::string one = simulate()[0], copy = folder_.put("copy.csv", content(one));
  refused({"identify", mill_, one, copy}, "again");
  const std::string small = folder_.put("small.toml", kMill + "[axis.Y]\nrange = [-90, 200]\n");
  const std::string out = folder_ / "x";
  refused({"simulate", "ballbar", small, "--test", plan, "--out", out}, "leaves the travel of Y");
  refused({"simulate", "ballbar", mill_, "--test", "plane=XY,radius=100,feed=0.01", "--out", out},
          "cycles of the bus");
  const std::string upper = "plane=XY,radius=100,feed=2000,from=10,to=170,overshoot=5";
  EXPECT_EQ(abbe({"simulate", "ballbar", small, "--test", upper, "--out", out}).exit, 0);
  refused({"simulate", "ballbar", mill_, "--test", plan, "--lag", "Q=1", "--out", folder_ / "x"}, "--lag");
  refused({"identify", mill_, folder_ / "absent.csv"}, "E-FILE");
  refused({"identify", mill_, folder_.put("a.csv", "angle_deg,deviation_um\n")}, "does not say the plane");
}

}  // namespace
}  // namespace abbe::cli
