// Methods of correction, paths, and cutter locations corrected by measured deviations, as scripts use them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "abbe/chain/test_grinder.h"
#include "machines.h"
#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class Methods : public ::testing::Test {
 protected:
  json answer(std::vector<std::string> arguments, std::string_view input = {}, int exit = 0) {
    arguments.push_back("--json");
    const ProgramRun run = run_abbe(arguments, input, folder_.path());
    EXPECT_EQ(run.exit, exit) << run.err;
    return json::parse(run.out, nullptr, false);
  }
  std::string read(const std::string& path) {
    std::ifstream in(path);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }

  Folder folder_;
  std::string three_ = folder_.put("three.toml", kThreeAxes);
  std::string five_ = folder_.put("five.toml", kFiveAxes);
  std::string grinder_ = folder_.put("grinder.toml", grinder::text(0));
  std::string ideal_ = folder_.put("ideal.toml", grinder::kText);
};

TEST_F(Methods, FourWaysToOneAnswer) {
  const grinder::Case& c = grinder::kCases[0];
  const std::string at = "X=" + std::to_string(c.ideal[0]) + ",Y=" + std::to_string(c.ideal[1]) +
                         ",Z=" + std::to_string(c.ideal[2]) + ",A=" + std::to_string(c.ideal[3]) +
                         ",C=" + std::to_string(c.ideal[4]);
  const auto by = [&](const std::string& method) {
    const json read = answer({"correct", grinder_, "--at", at, "--method", method});
    EXPECT_EQ(read["method"], method);
    EXPECT_EQ(read["points"][0]["status"], "ok");
    return read["points"][0];
  };
  const json newton = by("newton"), closed = by("closed-form"), printed = by("printed"),
             step = by("one-step");
  EXPECT_LE(newton["residual"]["position_mm"], 1e-9);
  EXPECT_LE(closed["residual"]["position_mm"], 1e-11);
  EXPECT_NEAR(printed["residual"]["position_mm"], 6.55e-7, 1e-9);
  EXPECT_LE(step["residual"]["position_mm"], 2e-6);
  for (const char* axis : {"X", "Y", "Z"}) {
    EXPECT_NEAR(newton["corrected"][axis], closed["corrected"][axis], 1e-9);
    EXPECT_NEAR(printed["corrected"][axis], closed["corrected"][axis], 2e-6);
  }
}

TEST_F(Methods, AMethodThatDoesNotFitIsRefused) {
  for (const char* verb : {"correct", "inverse"}) {
    SCOPED_TRACE(verb);
    const std::string point = std::string(verb) == "correct" ? "--at" : "--pose";
    const std::string value = std::string(verb) == "correct" ? "X=1" : "0,0,0,0,0,1";
    const ProgramRun printed = run_abbe({verb, three_, point, value, "--method", "printed"});
    EXPECT_EQ(printed.exit, 2);
    EXPECT_THAT(printed.err, HasSubstr("E-METHOD"));
    EXPECT_EQ(printed.out, "");
    EXPECT_EQ(run_abbe({verb, five_, point, value, "--method", "closed-form", "--lock", "Y"}).exit, 2);
    EXPECT_EQ(run_abbe({verb, five_, point, value, "--method", "closed-form", "--model", "first-order"}).exit,
              2);
  }
  EXPECT_EQ(run_abbe({"correct", three_, "--at", "X=1", "--set", "T1=20", "--method", "closed-form"}).exit,
            0);
}

TEST_F(Methods, APathGoesOnInsteadOfJumpingByATurn) {
  const std::string rows = "X,Y,Z,A,C\n0,0,0,30,170\n0,0,0,30,-170\n0,0,0,30,-150\n";
  const json jumps = answer({"correct", five_, "--points", "-"}, rows);
  EXPECT_EQ(jumps["points"][1]["commanded"]["C"], -170);
  EXPECT_FALSE(jumps.contains("path"));
  const json path = answer({"correct", five_, "--points", "-", "--path", "--method", "closed-form"}, rows);
  EXPECT_NEAR(path["points"][1]["commanded"]["C"], 190, 1e-9);
  EXPECT_NEAR(path["points"][2]["corrected"]["C"], 210, 0.01);
  EXPECT_NEAR(path["path"]["largest_step"]["C"], 20, 0.01);
  EXPECT_EQ(path["path"]["points"], 3);
  EXPECT_EQ(path["path"]["branch_changes"], 0);
  const ProgramRun text = run_abbe({"correct", five_, "--points", "-", "--path"}, rows);
  EXPECT_THAT(text.out, HasSubstr("largest step between neighbours:"));
}

TEST_F(Methods, PosesAreAPath) {
  std::string rows = "x_mm,y_mm,z_mm,i,j,k\n";
  for (int i = 0; i <= 12; ++i) {
    const double around = i * 0.6;
    rows += "10,20,30," + std::to_string(0.5 * std::cos(around)) + "," +
            std::to_string(0.5 * std::sin(around)) + ",0.8660254\n";
  }
  const json read = answer({"inverse", grinder_, "--poses", "-", "--near", "A=0.5"}, rows);
  EXPECT_EQ(read["path"]["branch_changes"], 0);
  EXPECT_NEAR(read["path"]["largest_step"]["C"], 0.6 * 180 / M_PI, 0.01);
  for (const json& point : read["points"]) EXPECT_FALSE(point["branch_changed"]);
}

class ClCorrect : public Methods {
 protected:
  // 50-digit arithmetic from the equations of step 4 of seed 003.
  static constexpr const char* kPose =
      "35.5,-62.25,48.75,0.4698463103929542,0.17101007166283436,0.8660254037844386";
  static constexpr const char* kGear =
      "gear_static_x_um,gear_static_y_um,gear_static_z_um,gear_static_a_urad,gear_static_b_urad,"
      "gear_static_c_urad,gear_motion_x_mm,gear_motion_y_mm,gear_motion_z_mm,gear_motion_a_rad,"
      "gear_motion_b_rad,gear_motion_c_rad";
  static constexpr const char* kGearRow =
      "-1.69,4.7,-3.46,-0.96,1.66,-4.51,-0.00426,0.0034,0.00048,-4.04e-06,-1.26e-06,9.6e-07";
  static constexpr const char* kTool =
      "tool_static_x_um,tool_static_y_um,tool_static_z_um,tool_static_a_urad,tool_static_b_urad,"
      "tool_static_c_urad,tool_motion_x_um,tool_motion_y_um,tool_motion_z_um,tool_motion_a_urad,"
      "tool_motion_b_urad,tool_motion_c_urad";
  static constexpr const char* kToolRow =
      "-4.41,4.31,0.19,-2.81,-4.62,-4.12,-0.56,-0.72,-4.29,-2.54,-4.08,0.64";

  std::string all_ =
      folder_.put("all.csv", std::string(kGear) + "," + kTool + "\n" + kGearRow + "," + kToolRow + "\n");
  std::string gear_ = folder_.put("gear.csv", std::string(kGear) + "\n" + kGearRow + "\n");
  std::vector<std::string> with(const std::string& machine, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"cl-correct", machine, "--near", "A=0.5,C=-1.9"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

TEST_F(ClCorrect, TwentyFourDeviationsMoveThePose) {
  const json read = answer(with(ideal_, {"--pose", kPose, "--deviations", all_}));
  const json& point = read["points"][0];
  const std::array<double, 6> expected = {35.49699657593633,   -62.23534751008439, 48.74907275415551,
                                          0.46984864209044247, 0.1710224938064201, 0.8660216857203983};
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(point["corrected_pose"][i], expected[i], i < 3 ? 1e-12 : 1e-14);
  EXPECT_NEAR(point["static"]["position_mm"][1], -0.00997486149609908, 1e-14);
  EXPECT_NEAR(point["motion"]["rotation_rad"][0], 8.529727342604134e-06, 1e-18);
  EXPECT_EQ(point["status"], "ok");
  EXPECT_TRUE(read["sources"]["gear_deviations"]);

  // The same from columns beside the poses, and a file of corrected poses that `inverse` reads.
  const std::string rows = std::string("x,y,z,i,j,k,") + kTool + "\n" + kPose + "," + kToolRow + "\n" +
                           kPose + "," + kToolRow + "\n";
  const json beside =
      answer(with(ideal_, {"--poses", "-", "--deviations", gear_, "-o", folder_ / "out.csv"}), rows);
  EXPECT_EQ(beside["points"][1]["corrected_pose"], point["corrected_pose"]);
  const json inverse = answer({"inverse", ideal_, "--poses", folder_ / "out.csv", "--near", "A=0.5,C=-1.9"});
  EXPECT_EQ(inverse["points"].size(), 2U);
  EXPECT_NEAR(inverse["points"][0]["q"]["Y"], point["q"]["Y"], 1e-9);
}

TEST_F(ClCorrect, NothingIsCountedTwice) {
  const auto arguments = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = {"--pose", kPose, "--deviations", gear_, "--method", "closed-form"};
    all.insert(all.end(), more.begin(), more.end());
    return with(grinder_, all);
  };
  const ProgramRun refused = run_abbe(arguments({}));
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("E-TWICE"));
  EXPECT_THAT(refused.err, HasSubstr("side of the gear"));
  EXPECT_THAT(refused.err, ::testing::Not(HasSubstr("side of the tool")));
  const auto by = [&](const std::string& sources) { return answer(arguments({"--sources", sources})); };
  const json model = by("model"), deviations = by("deviations"), both = by("both");
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(model["points"][0]["corrected_pose"][i], model["points"][0]["pose"][i], 1e-15);
  EXPECT_NE(deviations["points"][0]["corrected_pose"], deviations["points"][0]["pose"]);
  EXPECT_EQ(deviations["points"][0]["corrected_pose"], both["points"][0]["corrected_pose"]);
  // deviations: the errors of X, C and the workpiece are left out of the commands, those of the tool stay.
  EXPECT_EQ(model["sources"]["machine_errors"], 53);
  EXPECT_LT(deviations["sources"]["machine_errors"], 53);
  EXPECT_GT(
      std::abs(deviations["points"][0]["q"]["X"].get<double>() - both["points"][0]["q"]["X"].get<double>()),
      1e-3);
}

TEST_F(ClCorrect, MistakesAreNamed) {
  const auto run = [&](const std::string& csv, std::vector<std::string> more = {}) {
    std::vector<std::string> all = {"--pose", kPose, "--deviations", folder_.put("d.csv", csv)};
    all.insert(all.end(), more.begin(), more.end());
    return run_abbe(with(ideal_, all));
  };
  EXPECT_THAT(run("gear_static_x_um\n1\n").err, HasSubstr("gear_static_y_um"));
  EXPECT_EQ(run("gear_static_x_um\n1\n").exit, 2);
  EXPECT_EQ(run("gear_static_x_inch\n1\n").exit, 2);
  EXPECT_EQ(run(std::string(kGear) + "\n" + kGearRow + "\n" + kGearRow + "\n").exit, 2);
  EXPECT_EQ(run(std::string(kGear) + "\n").exit, 2);
  EXPECT_EQ(run("").exit, 2);
  EXPECT_EQ(run(std::string(kGear) + ",gear_static_x_mm\n" + kGearRow + ",0.1\n").exit, 2);
  EXPECT_EQ(run_abbe(with(ideal_, {"--pose", kPose})).exit, 2);
  EXPECT_EQ(run_abbe(with(ideal_, {"--pose", kPose, "--deviations", gear_, "-o", gear_})).exit, 2);
  // A pose that cannot be reached: no file.
  std::string text = grinder::kText;
  text.replace(text.find("[axis.A]"), 8, "[axis.A]\nrange = [-0.1, 0.1]");
  const std::string stiff = folder_.put("stiff.toml", text);
  const ProgramRun unreachable =
      run_abbe(with(stiff, {"--pose", kPose, "--deviations", gear_, "-o", folder_ / "none.csv"}));
  EXPECT_EQ(unreachable.exit, 5);
  EXPECT_EQ(read(folder_ / "none.csv"), "");
}

}  // namespace
}  // namespace abbe::cli
