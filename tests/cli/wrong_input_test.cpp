// What users do wrong, and what ends the program: each with the exit code of docs/command-line.md and a
// message that says where and what to do.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "machines.h"
#include "run_program.h"

namespace abbe::cli {
namespace {

using ::testing::HasSubstr;

class WrongInput : public ::testing::Test {
 protected:
  Folder folder_;
  std::string machine_ = folder_.put("three.toml", kThreeAxes);

  ProgramRun predict_rows(std::string_view rows) {
    return run_abbe({"predict", machine_, "--set", "T1=20", "--points", "-"}, rows);
  }
};

TEST(Usage, HelpAndVersionAreAnswers) {
  for (const char* verb :
       {"describe", "derive", "predict", "map", "correct", "inverse", "cl-correct", "signcheck", "compensate",
        "check", "verify", "diff", "explain", "evaluate", "fit"}) {
    const ProgramRun run = run_abbe({verb, "--help"});
    EXPECT_EQ(run.exit, 0) << verb;
    EXPECT_THAT(run.out, HasSubstr("Usage")) << verb;
    EXPECT_EQ(run.err, "") << verb;
  }
  EXPECT_EQ(run_abbe({"--help"}).exit, 0);
  const ProgramRun version = run_abbe({"--version"});
  EXPECT_EQ(version.exit, 0);
  EXPECT_THAT(version.out, HasSubstr("abbe "));
}

TEST(Usage, MisspeltWordsGetASuggestion) {
  const ProgramRun verb = run_abbe({"predikt", "m.toml"});
  EXPECT_EQ(verb.exit, 2);
  EXPECT_THAT(verb.err, HasSubstr("did you mean predict?"));
  const ProgramRun option = run_abbe({"predict", "m.toml", "--modl", "rigid"});
  EXPECT_EQ(option.exit, 2);
  EXPECT_THAT(option.err, HasSubstr("did you mean --model?"));
  EXPECT_EQ(run_abbe({}).exit, 2);
  EXPECT_EQ(run_abbe({"predict"}).exit, 2);
  EXPECT_EQ(run_abbe({"predict", "m.toml", "--model", "exact"}).exit, 2);
  EXPECT_EQ(run_abbe({"predict", "m.toml", "--limit-um", "-3"}).exit, 2);
  EXPECT_EQ(run_abbe({"correct", "m.toml", "--method", "magic"}).exit, 2);
}

TEST_F(WrongInput, MachineFilesThatAreNone) {
  EXPECT_EQ(run_abbe({"describe", folder_ / "absent.toml"}).exit, 2);
  EXPECT_EQ(run_abbe({"describe", folder_.path()}).exit, 2);
  EXPECT_EQ(run_abbe({"describe", folder_.put("empty.toml", "")}).exit, 2);
  EXPECT_EQ(run_abbe({"describe", "-"}, "").exit, 2);
  EXPECT_EQ(run_abbe({"describe", machine_, "--errors", folder_ / "absent.toml"}).exit, 2);
  const std::string whole(kThreeAxes);
  for (std::size_t length = 1; length < whole.find("[errors]"); length += 7) {
    const ProgramRun run =
        run_abbe({"predict", "-", "--at", "X=1", "--set", "T1=20"}, whole.substr(0, length));
    EXPECT_TRUE(run.exit == 2 || run.exit == 0) << "first " << length << " bytes: exit " << run.exit;
    if (run.exit == 2) {
      EXPECT_THAT(run.err, HasSubstr("error[E-"));
    }
  }
  const ProgramRun read = run_abbe({"predict", "-", "--at", "X=1", "--set", "T1=20"}, whole);
  EXPECT_EQ(read.exit, 0) << read.err;
}

TEST_F(WrongInput, RandomBytesAsMachineAndAsPoints) {
  std::mt19937_64 random{17};
  for (int k = 0; k < 30; ++k) {
    std::string bytes(random() % 300, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    EXPECT_EQ(run_abbe({"describe", "-"}, bytes).exit, 2) << "draw " << k;
    EXPECT_EQ(predict_rows("X,Y,Z\n1,2,3\n," + bytes).exit, 2) << "draw " << k;
  }
}

TEST_F(WrongInput, MissingSensorNamesItsErrorAndTheRemedy) {
  const ProgramRun run = run_abbe({"predict", machine_, "--at", "X=1"});
  EXPECT_EQ(run.exit, 2);
  EXPECT_THAT(run.err, HasSubstr("E-SENSOR"));
  EXPECT_THAT(run.err, HasSubstr("TZZ"));
  EXPECT_THAT(run.err, HasSubstr("--set T1=VALUE"));
}

TEST_F(WrongInput, CellsAreNamedByLineAndColumn) {
  const auto place = [&](std::string_view rows, const char* where) {
    const ProgramRun run = predict_rows(rows);
    EXPECT_EQ(run.exit, 2) << rows;
    EXPECT_THAT(run.err, HasSubstr(where)) << rows;
  };
  place("X,Y,Z\n1,2,3\n4,,6\n", "<stdin>:3:3: error[E-CELL]");
  place("X,Y,Z\n1,2,abc\n", "<stdin>:2:5: error[E-CELL]");
  place("X,Y,Z\n1,nan,3\n", "<stdin>:2:3: error[E-CELL]");
  place("X,Y,Z\n1,2,inf\n", "<stdin>:2:5: error[E-CELL]");
  place("X,Y,Z\n1,2,1e999\n", "<stdin>:2:5: error[E-CELL]");
  place("X,Y,Z\n1,2\n", "<stdin>:2:3: error[E-CSV]");
  place("X,Y,Z\n1,2,3,4\n", "<stdin>:2:7: error[E-CSV]");
  place("X,Y,Z\n1,2,3\n\n4,5,6\n", "<stdin>:3:1: error[E-CSV]");
  place("X,Y\n1,2\n", "no column for the axis 'Z'");
  place("X,Y,Z,X\n1,2,3,4\n", "a second column 'X'");
  place("X,Y,Z,X.dir\n1,2,3,x\n", "<stdin>:2:7: error[E-CELL]");
  place("X,Y,Z,T1\n1,2,3,20\n", "also given on the command line");
  place("", "no header row");
  EXPECT_EQ(run_abbe({"predict", machine_, "--set", "T1=20", "--points", folder_ / "absent.csv"}).exit, 2);
  EXPECT_EQ(run_abbe({"predict", machine_, "--set", "T1=20", "--points", folder_.path()}).exit, 2);
}

TEST_F(WrongInput, WhatIsHarmlessIsRead) {
  const auto good = [&](std::string_view rows) {
    const ProgramRun run = predict_rows(rows);
    EXPECT_EQ(run.exit, 0) << rows << run.err;
    return run.err;
  };
  EXPECT_EQ(good("\xEF\xBB\xBFX,Y,Z\r\n1,2,3\r\n"), "");
  EXPECT_EQ(good("X,Y,Z\n1, 2 ,3"), "");
  EXPECT_EQ(good("X,Y,Z\n1,2,3\n\n\n"), "");
  EXPECT_EQ(good("\"X\",\"Y\",\"Z\"\n1,\"2\",3\n"), "");
  EXPECT_THAT(good("X,Y,Z,remark\n1,2,3,rough\n"),
              HasSubstr("warning[W-COLUMN]: column 'remark' is ignored"));
}

TEST_F(WrongInput, JsonStaysJsonWhenTheRunStops) {
  const ProgramRun run =
      run_abbe({"predict", machine_, "--set", "T1=20", "--points", "-", "--json"}, "X,Y,Z\n1,2,3\n4,x,6\n");
  EXPECT_EQ(run.exit, 2);
  const auto read = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_FALSE(read.is_discarded());
  EXPECT_EQ(read["points"].size(), 1U);
  EXPECT_FALSE(read["complete"]);
}

TEST_F(WrongInput, OptionsThatMeanNothingHere) {
  const auto refused = [&](std::vector<std::string> more, const char* message) {
    std::vector<std::string> arguments = {"predict", machine_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = run_abbe(arguments);
    EXPECT_EQ(run.exit, 2) << message;
    EXPECT_THAT(run.err, HasSubstr(message));
  };
  refused({"--at", "Q=1", "--set", "T1=20"}, "this machine has no 'Q'");
  refused({"--at", "x=1", "--set", "T1=20"}, "did you mean 'X'?");
  refused({"--at", "X=one", "--set", "T1=20"}, "not a number");
  refused({"--at", "X=1,X=2", "--set", "T1=20"}, "given twice");
  refused({"--at", "X", "--set", "T1=20"}, "NAME=VALUE");
  refused({"--at", "X=1", "--set", "X=20"}, "is an axis");
  refused({"--at", "X=1", "--set", "T1=20", "--approach", "X=up"}, "not a direction");
  refused({"--at", "X=1", "--set", "T1=20", "--approach", "Q=+"}, "no moving axis 'Q'");
  refused({"--set", "T1=20"}, "no point is given");
  EXPECT_EQ(run_abbe({"predict", machine_, "--at", "X=1", "--points", "p.csv"}).exit, 2);
  EXPECT_EQ(run_abbe({"correct", machine_, "--at", "X=1", "--set", "T1=20", "--lock", "Q"}).exit, 2);
  EXPECT_EQ(run_abbe({"inverse", machine_, "--set", "T1=20", "--pose", "1,2,3"}).exit, 2);
  EXPECT_EQ(run_abbe({"inverse", machine_, "--set", "T1=20", "--pose", "1,2,3,0,0,0"}).exit, 2);
  EXPECT_EQ(run_abbe({"inverse", machine_, "--set", "T1=20", "--poses", "-"}, "x,y,z\n1,2,3\n").exit, 2);
}

TEST_F(WrongInput, NumbersOutsideTheirRangeAndNoneAtAll) {
  const auto refused = [&](std::vector<std::string> words, const std::string& value) {
    words.push_back(value);
    const ProgramRun run = run_abbe(words);
    EXPECT_EQ(run.exit, 2) << words.front();
    EXPECT_THAT(run.err, HasSubstr("'" + value + "' is not a number")) << words.front();
    EXPECT_LT(run.err.size(), 200U) << run.err;
  };
  const std::string any = folder_ / "any";
  const std::vector<std::vector<std::string>> options = {
      {"inspect", any, any, "--probe-size-um"},
      {"inspect", any, any, "--probe-scale-ppm"},
      {"inspect", any, any, "--beside-mm"},
      {"machine", any, any, "--surface", any, "--reach-mm"},
      {"machine", any, any, "--surface", any, "--noise-um"},
      {"toolpath", any, "--scallop-um"},
      {"toolpath", any, "--feed"},
      {"compensate", any, any, "--max-correction-um"},
      {"inverse", any, "--emit", "gcode", "--tolerance-um"},
      {"simulate", "capture", "--cycle-us"},
      {"predict", any, "--limit-um"},
      {"correct", any, "--max-rotary-correction"},
      {"gear", "correct", any, any, "--sigma-um"},
  };
  for (const auto& option : options)
    for (const char* value : {"nan", "inf", "1e999", "-1e5", "5um"}) refused(option, value);
  refused({"inspect", any, any, "--probe-um"}, "1001");
  refused({"correct", any, "--max-rotary-correction"}, "0");
  const ProgramRun zero = run_abbe({"predict", machine_, "--at", "X=1", "--set", "T1=20", "--limit-um", "0"});
  EXPECT_EQ(zero.exit, 0) << zero.err;
}

TEST_F(WrongInput, StrictTurnsWarningsIntoFour) {
  EXPECT_EQ(run_abbe({"predict", machine_, "--at", "X=1", "--set", "T1=20,T7=1"}).exit, 0);
  EXPECT_EQ(run_abbe({"predict", machine_, "--at", "X=1", "--set", "T1=20,T7=1", "--strict"}).exit, 4);
  // Outside wins over warnings.
  EXPECT_EQ(run_abbe({"correct", machine_, "--at", "X=500", "--set", "T1=20,T7=1", "--strict"}).exit, 5);
}

TEST_F(WrongInput, EnvironmentIsOneRow) {
  const auto with = [&](std::string_view text) {
    return run_abbe({"predict", machine_, "--at", "X=1", "--environment", folder_.put("env.csv", text)});
  };
  EXPECT_EQ(with("T1\n20\n").exit, 0);
  EXPECT_EQ(with("T1\n").exit, 2);
  EXPECT_EQ(with("T1\n20\n21\n").exit, 2);
  EXPECT_EQ(with("T1,T7\n20,1\n").exit, 0);
  EXPECT_EQ(with("X\n20\n").exit, 2);
  EXPECT_EQ(with("T1\nwarm\n").exit, 2);
  EXPECT_EQ(with("").exit, 2);
}

TEST_F(WrongInput, ManyRedundantAxesNeedALock) {
  const std::string machine =
      folder_.put("many.toml",
                  "format = 1\n[machine]\nname = \"many\"\nchain = \"w b X Y Z P t\"\n"
                  "[axis.P]\ntype = \"linear\"\ndirection = [0, 0, 1]\n[errors]\nEXX = 1\n");
  const ProgramRun run = run_abbe({"correct", machine, "--at", "X=1"});
  EXPECT_EQ(run.exit, 2);
  EXPECT_THAT(run.err, HasSubstr("--lock"));
  EXPECT_EQ(run_abbe({"correct", machine, "--at", "X=1", "--lock", "P"}).exit, 0);
}

/// Standard output connected to `target` instead of a file.
int exit_with_output(const std::vector<std::string>& arguments, int output) {
  std::vector<std::string> words = {program_path()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(output, STDOUT_FILENO);
    ::dup2(::open("/dev/null", O_WRONLY), STDERR_FILENO);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST_F(WrongInput, OutputThatCannotBeWrittenIsNoSuccess) {
  const int full = ::open("/dev/full", O_WRONLY);
  if (full < 0) GTEST_SKIP() << "no /dev/full here";
  EXPECT_EQ(exit_with_output({"describe", machine_}, full), 1);
  EXPECT_EQ(exit_with_output({"--help"}, full), 1);
  ::close(full);
  int pipe[2];
  ASSERT_EQ(::pipe(pipe), 0);
  ::close(pipe[0]);
  EXPECT_EQ(exit_with_output({"describe", machine_}, pipe[1]), 1);
  ::close(pipe[1]);
}

TEST_F(WrongInput, AFileSizeLimitLeavesNothingBehind) {
  std::string program = "G54\nG0 X0 Y0 Z0\n";
  for (int i = 0; i < 20000; ++i) program += i % 2 == 0 ? "G0 X1\n" : "G0 X2\n";
  const std::string part = folder_.put("part.ngc", program);
  const Folder target;
  const std::string out = target / "out.ngc";
  const pid_t child = ::fork();
  if (child == 0) {
    const struct rlimit small = {8192, 8192};
    ::setrlimit(RLIMIT_FSIZE, &small);
    const int nowhere = ::open("/dev/null", O_WRONLY);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    ::execl(program_path().c_str(), "abbe", "compensate", machine_.c_str(), part.c_str(), "-o", out.c_str(),
            "--set", "T1=20", "--offset", "G54=X0,Y0,Z0", nullptr);
    ::_exit(127);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_TRUE(std::filesystem::is_empty(target.path()));
}

TEST_F(WrongInput, InterruptEndsTheWaitForStandardInput) {
  int pipe[2];
  ASSERT_EQ(::pipe2(pipe, O_CLOEXEC), 0);  // nobody writes: the program waits in read()
  const Folder temporary;
  const std::string out = folder_ / "out.ngc";
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(pipe[0], STDIN_FILENO);
    ::setenv("TMPDIR", temporary.path().c_str(), 1);
    ::execl(program_path().c_str(), "abbe", "compensate", machine_.c_str(), "-", "-o", out.c_str(), "--set",
            "T1=20", "--offset", "G54=X0,Y0,Z0", nullptr);
    ::_exit(127);
  }
  ASSERT_EQ(::write(pipe[1], "G54\nG0 X0 Y0 Z0\n", 17), 17);
  // The copy of standard input appears when the program is about to wait.
  for (int k = 0; k < 500 && std::filesystem::is_empty(temporary.path()); ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_EQ(::kill(child, SIGINT), 0);
  int status = 0;
  ::waitpid(child, &status, 0);
  ::close(pipe[0]);
  ::close(pipe[1]);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_TRUE(std::filesystem::is_empty(temporary.path()));
}

TEST_F(WrongInput, InterruptEndsWith130) {
  std::string rows = "X,Y,Z\n";
  for (int i = 0; i < 400000; ++i) rows += "1,2,3\n";
  const std::string points = folder_.put("long.csv", rows);
  int pipe[2];
  ASSERT_EQ(::pipe(pipe), 0);  // nobody reads: the program waits in write()
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(pipe[1], STDOUT_FILENO);
    ::execl(program_path().c_str(), "abbe", "predict", machine_.c_str(), "--set", "T1=20", "--json",
            "--points", points.c_str(), nullptr);
    ::_exit(127);
  }
  ::close(pipe[1]);
  char first[64];
  ASSERT_GT(::read(pipe[0], first, sizeof first), 0);
  ASSERT_EQ(::kill(child, SIGINT), 0);
  std::vector<char> rest(1 << 16);
  while (::read(pipe[0], rest.data(), rest.size()) > 0) {
  }
  ::close(pipe[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
}

}  // namespace
}  // namespace abbe::cli
