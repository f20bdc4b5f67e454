// `abbe evaluate`: figures in text, JSON and SVG, and what is refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr const char* kRuns =
    "target [mm],run,direction,deviation [um]\n"
    "0,1,+,0\n100,1,+,2\n200,1,+,4\n200,1,-,5\n100,1,-,3\n0,1,-,1\n"
    "0,2,+,0\n100,2,+,4\n200,2,+,4\n200,2,-,5\n100,2,-,3\n0,2,-,1\n";

class Evaluate : public ::testing::Test {
 protected:
  ProgramRun evaluate(std::vector<std::string> options) {
    options.insert(options.begin(), {"evaluate"});
    return run_abbe(options, {}, folder_.path());
  }
  Folder folder_;
  std::string runs_ = folder_.put("runs.csv", kRuns);
};

TEST_F(Evaluate, JsonIsWhatIsWorkedOutInTheHead) {
  const ProgramRun run = evaluate({runs_, "--as", "positioning", "--json"});
  ASSERT_EQ(run.exit, 0) << run.err;
  const json read = json::parse(run.out);
  EXPECT_EQ(read["unit"], "mm");
  EXPECT_EQ(read["edition"], "ISO 230-2:2014");
  EXPECT_EQ(read["coverage_factor"], 2);
  EXPECT_NEAR(read["figures"]["E"], 5e-3, 1e-12);
  EXPECT_NEAR(read["figures"]["M"], 4e-3, 1e-12);  // 0.5 to 4.5
  EXPECT_NEAR(read["figures"]["B"], 1e-3, 1e-12);
  EXPECT_NEAR(read["figures"]["mean_reversal"], -2e-3 / 3, 1e-12);
  EXPECT_NEAR(read["figures"]["R"], 4e-3 * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(read["targets"][1]["s_forward"], 1e-3 * std::sqrt(2.0), 1e-12);
}

TEST_F(Evaluate, FigureAppears) {
  const std::string svg = folder_ / "runs.svg";
  ASSERT_EQ(evaluate({runs_, "--as", "straightness", "--svg", svg}).exit, 0);
  EXPECT_GT(std::filesystem::file_size(svg), 1000U);
  EXPECT_EQ(evaluate({runs_, "--as", "positioning", "--svg", runs_}).exit, 2);
}

TEST_F(Evaluate, DiagonalsShowSquareness) {
  const std::string head = "target [mm],run,direction,deviation [um]\n0,1,+,0\n640.312,1,+,";
  const std::string pp = folder_.put("pp.csv", head + "-6.24695\n"),
                    np = folder_.put("np.csv", head + "6.24695\n");
  const ProgramRun run = evaluate({pp, np, "--as", "diagonals", "--sides", "500,400", "--json"});
  ASSERT_EQ(run.exit, 0) << run.err;
  EXPECT_NEAR(json::parse(run.out)["squareness_rad"], 20e-6, 1e-9);
  EXPECT_EQ(evaluate({pp, np, "--as", "diagonals", "--sides", "500"}).exit, 2);
  EXPECT_EQ(evaluate({pp, np, "--as", "positioning"}).exit, 2);
}

TEST_F(Evaluate, DiagonalsOfAnotherBoxAndCopiesAreRefused) {
  const std::string head = "target [mm],run,direction,deviation [um]\n0,1,+,0\n640.312,1,+,";
  const std::string pp = folder_.put("pp.csv", head + "-6\n"), np = folder_.put("np.csv", head + "6\n"),
                    copy = folder_.put("copy.csv", head + "-6.0\n");
  const auto refusal = [&](const std::string& second, const char* sides) {
    const ProgramRun run = evaluate({pp, second, "--as", "diagonals", "--sides", sides});
    EXPECT_EQ(run.exit, 2) << run.out;
    EXPECT_EQ(run.out, "");
    return run.err;
  };
  EXPECT_THAT(refusal(np, "0.5,0.4"), HasSubstr("640.312 mm long"));  // metres
  EXPECT_THAT(refusal(np, "500,417"), HasSubstr("640.312 mm long"));  // 1.7 % longer
  EXPECT_THAT(refusal(copy, "500,400"), HasSubstr("copy.csv has the readings of a file before it"));
  EXPECT_THAT(refusal(pp, "500,400"), HasSubstr("pp.csv has the readings"));
  EXPECT_EQ(evaluate({pp, np, "--as", "diagonals", "--sides", "500,404"}).exit, 0);  // 0.4 %
}

TEST_F(Evaluate, WhatIsWrongIsNamed) {
  const std::string text =
      folder_.put("bad.csv", "target [mm],run,direction,deviation [um]\n0,1,+,0\n100,1,+,nan\n");
  const ProgramRun run = evaluate({text, "--as", "positioning"});
  EXPECT_EQ(run.exit, 2);
  EXPECT_THAT(run.err, HasSubstr("bad.csv:3"));
  EXPECT_THAT(run.err, HasSubstr("E-MEASURED-CELL"));
  EXPECT_EQ(evaluate({runs_, "--as", "angle"}).exit, 2);
  EXPECT_EQ(evaluate({runs_, "--as", "drift"}).exit, 2);
  EXPECT_EQ(evaluate({folder_ / "none.csv", "--as", "drift"}).exit, 2);
}

}  // namespace
}  // namespace abbe::cli
