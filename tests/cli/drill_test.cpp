// compensate --expand-drill as a user meets it.

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

const std::string kLeaning = with_errors(kThreeAxes, "EXZ = { poly = [0, 0.2] }\n");

TEST(ExpandDrill, IsAskedForReportedAndVerified) {
  const Folder folder;
  const std::string machine = folder.put("m.toml", kLeaning), out = folder / "out.ngc",
                    program = folder.put(
                        "part.ngc", "G21 G90 G54\nG0 X0 Y0 Z10\nG99 G81 X5 Y5 Z-30 R2 F100\nX9\nG80\nM2\n");
  const std::vector<std::string> usual = {"compensate", machine,    program,       "-o",
                                          out,          "--offset", "G54=X0,Y0,Z0"};
  const auto refused = run_abbe(usual);
  EXPECT_EQ(refused.exit, 3);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("E-CYCLE"), HasSubstr("--expand-drill")));
  EXPECT_FALSE(std::filesystem::exists(out));

  auto expanding = usual;
  expanding.insert(expanding.end(), {"--expand-drill", "--json"});
  const auto done = run_abbe(expanding);
  ASSERT_EQ(done.exit, 0) << done.err;
  EXPECT_EQ(json::parse(done.out)["expanded_holes"], 2);
  const auto verified = run_abbe({"verify", machine, program, out, "--offset", "G54=X0,Y0,Z0"});
  EXPECT_EQ(verified.exit, 0) << verified.err;
  expanding.back() = "--strict";
  EXPECT_THAT(run_abbe(expanding).out, HasSubstr("2 holes are written as G0 and G1"));
}

TEST(ExpandDrill, IsNotForClData) {
  const Folder folder;
  const std::string machine = folder.put("m.toml", kLeaning),
                    program = folder.put("part.apt", "UNITS/MM\nGOTO/0,0,0\nFINI\n");
  const auto run = run_abbe({"check", machine, program, "--dialect", "apt", "--expand-drill"});
  EXPECT_EQ(run.exit, 2);
  EXPECT_THAT(run.err, HasSubstr("--expand-drill"));
}

}  // namespace
}  // namespace abbe::cli
