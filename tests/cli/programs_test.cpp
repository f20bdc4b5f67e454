// The verbs that read programs, end to end: exit codes, files that appear or not, the report.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <thread>

#include "machines.h"
#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kProgram =
    "G21 G17 G90 G94\n"
    "G54\n"
    "G0 X0 Y0 Z10\n"
    "G1 X100.000 Y0.000 Z0.000 F500\n"
    "G1 X200.000 Y50.000\n"
    "M2\n";

class Programs : public ::testing::Test {
 protected:
  ProgramRun compensate(const std::string& program, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"compensate", machine_,   program,          "-o", out_, "--set",
                                          "T1=20",      "--offset", "G54=X0,Y0,Z-100"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_abbe(arguments);
  }
  static std::string content(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  Folder folder_;
  std::string machine_ = folder_.put("three.toml", kThreeAxes);
  std::string program_ = folder_.put("part.ngc", kProgram);
  std::string out_ = folder_ / "out.ngc";
};

TEST_F(Programs, MuchLongerOutputIsWarnedOf) {
  std::string program = "G21 G17 G90 G94\nG54\nG0 X0 Y0 Z10\nF500\n";
  for (int i = 0; i < 200; ++i) program += i % 2 == 0 ? "G1 X300\n" : "G1 X0\n";
  program = folder_.put("long.ngc", program + "M2\n");
  EXPECT_THAT(compensate(program).err, Not(HasSubstr("W-GROWTH")));
  machine_ = folder_.put("wavy.toml", R"(format = 1
[machine]
name = "wavy"
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
[errors]
EXX = { sine = [20, 0.0628, 0] }
)");
  const ProgramRun grown =
      run_abbe({"compensate", machine_, program, "-o", out_, "--offset", "G54=X0,Y0,Z0"});
  EXPECT_EQ(grown.exit, 0) << grown.err;
  EXPECT_THAT(grown.err, HasSubstr("long.ngc: warning[W-GROWTH]: 205 lines became"));
}

TEST_F(Programs, WhatOnlyTheVerifyingReaderRefusesIsRefused) {
  // An arc of 0.8 urad, which LinuxCNC would make a full circle.
  const ProgramRun run =
      compensate(folder_.put("arc.ngc", "G54\nG0 X10 Y0.3 Z5\nG3 X10.00004 Y0.3 I0 J50 F100\nM2\n"));
  EXPECT_EQ(run.exit, 3) << run.err;
  EXPECT_THAT(run.err, HasSubstr("E-ARC"));
  EXPECT_FALSE(std::filesystem::exists(out_));
}

TEST_F(Programs, CompensateWritesProgramReportAndFigure) {
  const ProgramRun run =
      compensate(program_, {"--report", folder_ / "r.json", "--figure", folder_ / "f.svg"});
  ASSERT_EQ(run.exit, 0) << run.err;
  const std::string text = content(out_);
  EXPECT_THAT(text, HasSubstr("(ABBE COMPENSATED - DO NOT EDIT - DO NOT RE-COMPENSATE)"));
  // EXX 0.1 um/mm from the datum on: x = 200 - 0.020. EYY is constant and belongs to the datum.
  EXPECT_THAT(text, HasSubstr("X199.980"));
  EXPECT_THAT(text, HasSubstr("Y50.000"));
  const json report = json::parse(content(folder_ / "r.json"));
  EXPECT_EQ(report["input"]["lines"], 6);
  EXPECT_EQ(report["input"]["sha256"].get<std::string>().size(), 64U);
  EXPECT_NEAR(report["before"]["max_um"], 20, 0.01);
  EXPECT_LT(report["after"]["max_um"], 1);
  EXPECT_NEAR(report["datum"]["removed_um"][1], 5, 1e-6);
  for (const char* member :
       {"output", "quantisation_um", "blocks", "arcs", "warnings", "corrections", "calibration"}) {
    EXPECT_TRUE(report.contains(member)) << member;
  }
  EXPECT_THAT(content(folder_ / "f.svg"), HasSubstr("</svg>"));

  const ProgramRun verified =
      run_abbe({"verify", machine_, program_, out_, "--set", "T1=20", "--offset", "G54=X0,Y0,Z-100"});
  EXPECT_EQ(verified.exit, 0) << verified.err;
  // Never twice.
  const ProgramRun again = run_abbe({"compensate", machine_, out_, "-o", folder_ / "twice.ngc", "--set",
                                     "T1=20", "--offset", "G54=X0,Y0,Z-100"});
  EXPECT_EQ(again.exit, 3);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "twice.ngc"));
}

TEST_F(Programs, AWrongOutputIsFoundOut) {
  ASSERT_EQ(compensate(program_).exit, 0);
  std::string wrong = content(out_);
  wrong.replace(wrong.find("X199.980"), 8, "X199.880");
  const ProgramRun run = run_abbe({"verify", machine_, program_, folder_.put("wrong.ngc", wrong), "--set",
                                   "T1=20", "--offset", "G54=X0,Y0,Z-100"});
  EXPECT_EQ(run.exit, 6) << run.err;
}

TEST_F(Programs, RefusedProgramsLeaveNothingBehind) {
  const ProgramRun refused = compensate(folder_.put("odd.ngc", "G54\nG0 X0 Y0 Z0\nG1 X[#1+2] F100\nM2\n"));
  EXPECT_EQ(refused.exit, 3) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(out_));
  const ProgramRun outside = compensate(folder_.put("far.ngc", "G54\nG0 X0 Y0 Z0\nG1 X500 F100\nM2\n"));
  EXPECT_EQ(outside.exit, 5) << outside.err;
  EXPECT_FALSE(std::filesystem::exists(out_));
  EXPECT_EQ(compensate(folder_ / "absent.ngc").exit, 2);
  EXPECT_EQ(compensate(folder_.path()).exit, 2);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 4);
}

TEST_F(Programs, OptionsAreChecked) {
  EXPECT_EQ(compensate(program_, {"--gauge", "3=12"}).exit, 2);
  EXPECT_EQ(compensate(program_, {"--gauge", "T3=long"}).exit, 2);
  EXPECT_EQ(compensate(program_, {"--offset", "G99=X1,Y2,Z3"}).exit, 2);
  EXPECT_EQ(compensate(program_, {"--dialect", "klingon"}).exit, 2);
  EXPECT_EQ(compensate(program_, {"--tools", folder_ / "absent.tbl"}).exit, 2);
  EXPECT_EQ(run_abbe({"compensate", machine_, program_, "-o", program_, "--set", "T1=20", "--offset",
                      "G54=X0,Y0,Z-100"})
                .exit,
            3);
  EXPECT_EQ(content(program_), kProgram);
}

TEST_F(Programs, InterruptLeavesNothingBehind) {
  std::string text = "G54\nG0 X0 Y0 Z0\nF500\n";
  for (int i = 0; i < 400000; ++i) text += fmt::format("G1 X{}.{:03} Y{}\n", i % 150, i % 1000, i % 90);
  const std::string program = folder_.put("long.ngc", text + "M2\n");
  const auto entries = [&] { return std::distance(std::filesystem::directory_iterator(folder_.path()), {}); };
  const auto before = entries();
  int printed[2];
  ASSERT_EQ(::pipe(printed), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(printed[1], STDOUT_FILENO);
    ::execl(program_path().c_str(), "abbe", "compensate", machine_.c_str(), program.c_str(), "-o",
            out_.c_str(), "--json", "--set", "T1=20", "--offset", "G54=X0,Y0,Z-100", nullptr);
    ::_exit(127);
  }
  ::close(printed[1]);
  // The output begins to grow beside its final place: now it is being rewritten.
  for (int k = 0; k < 2000 && entries() == before; ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_GT(entries(), before);
  ASSERT_EQ(::kill(child, SIGINT), 0);
  std::string answer(4096, '\0');
  const ssize_t length = ::read(printed[0], answer.data(), answer.size());
  ::close(printed[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(entries(), before);
  ASSERT_GT(length, 0);
  answer.resize(static_cast<std::size_t>(length));
  EXPECT_EQ(json::parse(answer, nullptr, false)["result"], "stopped") << answer;
}

TEST_F(Programs, CheckWritesNothing) {
  const ProgramRun run =
      run_abbe({"check", machine_, program_, "--set", "T1=20", "--offset", "G54=X0,Y0,Z-100", "--json"});
  EXPECT_EQ(run.exit, 0) << run.err;
  EXPECT_NEAR(json::parse(run.out)["before"]["max_um"], 20, 0.01);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 2);
}

}  // namespace
}  // namespace abbe::cli
