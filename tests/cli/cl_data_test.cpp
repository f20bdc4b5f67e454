// CL data and machines from the command line, end to end.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "machines.h"
#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kPart =
    "UNITS/MM\nRAPID\nGOTO/0,0,10\nFEDRAT/500,MMPM\nGOTO/100,0,-10\nCOOLNT/OFF\nFINI\n";

class ClData : public ::testing::Test {
 protected:
  ProgramRun run(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--set", "T1=20"});
    return run_abbe(arguments);
  }
  static std::string content(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  Folder folder_;
  std::string machine_ = folder_.put("three.toml", kThreeAxes);
  std::string part_ = folder_.put("part.cls", kPart);
  std::string out_ = folder_ / "out.cls";
};

TEST_F(ClData, IsKnownByItsNameAndCompensated) {
  const ProgramRun done = run({"compensate", machine_, part_, "-o", out_, "--json"});
  ASSERT_EQ(done.exit, 0) << done.err;
  const json report = json::parse(done.out);
  EXPECT_EQ(report["settings"]["dialect"], "cl");
  EXPECT_EQ(report["result"], "verified");
  EXPECT_EQ(report["blocks"]["motion"], 2);
  EXPECT_NEAR(report["before"]["max_um"].get<double>(), 10, 0.1);
  EXPECT_LT(report["after"]["max_um"].get<double>(), 0.1);
  EXPECT_EQ(report["output"]["bytes"], std::filesystem::file_size(out_));
  // EXX = 0.1 um/mm: the tool is told 99.99 mm
  EXPECT_THAT(content(out_), HasSubstr("GOTO/99.99,0,-10\n"));
  EXPECT_THAT(content(out_), HasSubstr("$$ ABBE COMPENSATED"));
  EXPECT_EQ(run({"verify", machine_, part_, out_}).exit, 0);
  EXPECT_EQ(run({"verify", machine_, part_, part_}).exit, 6);
  EXPECT_EQ(run({"compensate", machine_, out_, "-o", folder_ / "twice.cls"}).exit, 3);
}

TEST_F(ClData, TheDialectMayBeStated) {
  const std::string text = folder_.put("part.txt", kPart);
  EXPECT_EQ(run({"check", machine_, text, "--dialect", "apt"}).exit, 0);
  EXPECT_NE(run({"check", machine_, text}).exit, 0);
}

TEST_F(ClData, ARefusalLeavesNothing) {
  const ProgramRun refused =
      run({"compensate", machine_, folder_.put("bad.cls", "UNITS/MM\nNURBS/1\n"), "-o", out_});
  EXPECT_EQ(refused.exit, 3);
  EXPECT_THAT(refused.err, HasSubstr("bad.cls:2:1: error[E-RECORD]"));
  EXPECT_FALSE(std::filesystem::exists(out_));
  EXPECT_EQ(run({"check", machine_, folder_.put("far.cls", "UNITS/MM\nGOTO/900,0,0\nFINI\n")}).exit, 5);
  EXPECT_EQ(run({"check", machine_, part_, "--reversal"}).exit, 2);
  EXPECT_EQ(run({"check", machine_, part_, "--pass-record", "GOTO"}).exit, 2);
}

TEST_F(ClData, ExplainSaysWhatBecameOfARecord) {
  const ProgramRun said = run({"explain", machine_, part_ + ":5", "--json"});
  ASSERT_EQ(said.exit, 0) << said.err;
  const json trace = json::parse(said.out);
  EXPECT_NEAR(trace["correction_um"][0].get<double>(), -10, 0.01);
  EXPECT_EQ(trace["after"], "GOTO/99.99,0,-10");
}

TEST_F(ClData, BecomesAProgramOfAxisWords) {
  const std::string program = folder_ / "part.ngc";
  const ProgramRun done = run({"inverse", machine_, "--poses", part_, "--emit", "gcode", "-o", program});
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_THAT(content(program), HasSubstr("G1 X99.9900 Z-10.0000 F500.0000\nM9\nM2\n"));
  EXPECT_THAT(content(program), HasSubstr("(ABBE COMPENSATED"));
  ASSERT_EQ(run({"inverse", machine_, "--poses", part_, "--emit", "gcode", "-o", program, "--ideal"}).exit,
            0);
  EXPECT_THAT(content(program), HasSubstr("G1 X100.0000 Z-10.0000"));
  EXPECT_THAT(content(program), Not(HasSubstr("COMPENSATED")));
  const std::string csv = folder_.put("poses.csv", "x,y,z,i,j,k\n0,0,10,0,0,1\n50,0,10,0,0,1\n");
  EXPECT_EQ(run({"inverse", machine_, "--poses", csv, "--emit", "gcode", "-o", program}).exit, 2);
  ASSERT_EQ(
      run({"inverse", machine_, "--poses", csv, "--emit", "gcode", "-o", program, "--feed", "300"}).exit, 0);
  EXPECT_THAT(content(program), HasSubstr("G1 X49.9950 F300.0000\n"));
  EXPECT_EQ(run({"inverse", machine_, "--poses", part_, "--emit", "gcode", "-o", part_}).exit, 2);
  EXPECT_EQ(content(part_), kPart);
}

// Y leans away from X by 1 mrad: 100 mm up, the tool stands 0.1 mm towards -X, and is told 0.1 mm more.
TEST_F(ClData, AMachineMayBeDescribedOnTheCommandLine) {
  const std::string program = folder_.put("part.ngc", "G21 G90 G54\nG0 X0 Y0 Z10\nG1 Y100 F100\nM2\n"),
                    out = folder_ / "out.ngc";
  const std::vector<std::string> machine = {"--skew", "XY=0.9mrad", "--scale", "Y=1.0001"};
  const auto with = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), machine.begin(), machine.end());
    return run_abbe(arguments);
  };
  ASSERT_EQ(with({"compensate", program, "-o", out, "--offset", "G54=X0,Y0,Z0"}).exit, 0);
  EXPECT_THAT(content(out), HasSubstr("G1 Y99.9900 F100 X0.0900"));
  EXPECT_EQ(with({"verify", program, out, "--offset", "G54=X0,Y0,Z0"}).exit, 0);
  EXPECT_EQ(with({"check", program, "--offset", "G54=X0,Y0,Z0"}).exit, 0);
  EXPECT_EQ(with({"explain", program + ":3", "--offset", "G54=X0,Y0,Z0"}).exit, 0);
  const ProgramRun there = with({"predict", "--at", "X=0,Y=100,Z=0", "--json"});
  ASSERT_EQ(there.exit, 0) << there.err;
  const json deviation = json::parse(there.out)["points"][0]["deviation"]["position_mm"];
  EXPECT_NEAR(deviation[0].get<double>(), -0.09, 1e-6);
  EXPECT_NEAR(deviation[1].get<double>(), 0.01, 5e-5);  // the cosine of the lean
  const std::string table = folder_.put("z.csv", "Z,EZZ\n0,0\n100,20\n");
  const ProgramRun pitch = run_abbe({"predict", "--pitch", "Z=" + table, "--at", "X=0,Y=0,Z=50", "--json"});
  ASSERT_EQ(pitch.exit, 0) << pitch.err;
  EXPECT_NEAR(json::parse(pitch.out)["points"][0]["deviation"]["position_mm"][2].get<double>(), 0.01, 1e-9);
}

TEST_F(ClData, WrongMachinesOnTheCommandLineAreSaid) {
  for (const auto& wrong : std::vector<std::vector<std::string>>{{"--skew", "XY=0.02"},
                                                                 {"--skew", "YX=1mrad"},
                                                                 {"--skew", "XY=1mrad,XY=1mrad"},
                                                                 {"--scale", "X=2"},
                                                                 {"--scale", "A=1"},
                                                                 {"--pitch", "X=absent.csv"},
                                                                 {machine_, "--scale", "X=1.0001"}}) {
    std::vector<std::string> arguments = {"predict", "--at", "X=0,Y=0,Z=0"};
    arguments.insert(arguments.end(), wrong.begin(), wrong.end());
    EXPECT_EQ(run_abbe(arguments).exit, 2) << wrong[1];
  }
  EXPECT_EQ(run_abbe({"check", "--scale", "X=1.0001"}).exit, 2);
  EXPECT_EQ(run_abbe({"check", machine_}).exit, 2);
}

}  // namespace
}  // namespace abbe::cli
