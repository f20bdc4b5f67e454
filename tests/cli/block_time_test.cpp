// compensate --min-block-time as a user meets it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "machines.h"
#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// Z sags by 2e-6 x^2 mm.
const std::string kSagging = with_errors(kThreeAxes, "EZX = { poly = [0, 0, 0.002] }\n");

class BlockTime : public ::testing::Test {
 protected:
  ProgramRun check(std::vector<std::string> more) {
    std::vector<std::string> arguments = {"check", machine_, program_, "--offset", "G54=X0,Y0,Z0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_abbe(arguments);
  }
  Folder folder_;
  std::string machine_ = folder_.put("m.toml", kSagging);
  /// 100 ms
  std::string program_ = folder_.put("part.ngc", "G21 G90 G54\nG0 X0 Y0 Z0\nG1 X100 F60000\nM2\n");
};

TEST_F(BlockTime, IsKeptReportedOrRefused) {
  const json usual = json::parse(check({"--json"}).out);
  EXPECT_LT(usual["shortest_split_ms"], 30);
  EXPECT_EQ(usual["held_splits"]["count"], 0);
  const auto held = check({"--min-block-time", "30", "--json"});
  ASSERT_EQ(held.exit, 0) << held.err;
  const json report = json::parse(held.out);
  EXPECT_GE(report["shortest_split_ms"], 29.9);
  EXPECT_EQ(report["held_splits"]["count"], 1);
  EXPECT_GT(report["held_splits"]["residual_um"], 0.5);
  EXPECT_THAT(check({"--min-block-time", "30"}).out,
              AllOf(HasSubstr("not split"), HasSubstr("ms at its feed")));
  const auto refused = check({"--min-block-time", "60"});
  EXPECT_EQ(refused.exit, 3);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("E-TOL"), HasSubstr("--min-block-time")));
}

TEST_F(BlockTime, MayBeStatedByAProfile) {
  const std::string profile =
      folder_.put("slow.toml", "format = 1\nextends = \"linuxcnc\"\n[motion]\nblock_time_ms = 30\n");
  EXPECT_EQ(json::parse(check({"--profile", profile, "--json"}).out)["held_splits"]["count"], 1);
  EXPECT_EQ(json::parse(
                check({"--profile", profile, "--min-block-time", "0", "--json"}).out)["held_splits"]["count"],
            0);
  EXPECT_EQ(check({"--min-block-time", "nan"}).exit, 2);
  EXPECT_EQ(check({"--min-block-time", "-1"}).exit, 2);
}

}  // namespace
}  // namespace abbe::cli
