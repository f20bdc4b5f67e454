#include "abbe/chain/relative_deviation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "abbe/chain/correct.h"
#include "abbe/chain/test_grinder.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

#define EXPECT_VEC_NEAR(a, b, tolerance) \
  EXPECT_LE(((a) - (b)).cwiseAbs().maxCoeff(), tolerance) << (a).transpose() << " vs " << (b).transpose()

Machine machine_of(const std::string& text) {
  return read_machine({"test.toml", text}, std::nullopt,
                      [](const std::string&) { return std::optional<std::string>(); })
      .value.value_or(Machine{});
}

// 50-digit arithmetic from the equations of step 4 of seed 003.
const PoseDeviations kStatic = {{{-0.00169, 0.0047, -0.00346}, {-9.6e-07, 1.66e-06, -4.51e-06}},
                                {{-0.00441, 0.00431, 0.00019}, {-2.81e-06, -4.62e-06, -4.12e-06}}};
const PoseDeviations kMotion = {{{-0.00426, 0.0034, 0.00048}, {-4.04e-06, -1.26e-06, 9.6e-07}},
                                {{-0.00056, -0.00072, -0.00429}, {-2.54e-06, -4.08e-06, 6.4e-07}}};

Pose ideal_pose() {
  const Machine machine = machine_of(grinder::kText);
  Query query;
  query.tool = tool_of(machine);
  const char* names[] = {"X", "Y", "Z", "A", "C"};
  for (std::size_t i = 0; i < 5; ++i)
    query.q.at(static_cast<std::size_t>(machine.find_axis(names[i]))) = grinder::kCases[0].ideal[i];
  return nominal_pose(std::get<Plan>(make_plan(machine, {})), query);
}

TEST(RelativeDeviation, TwentyFourBecomeTwelveBecomeAPose) {
  const Pose ideal = ideal_pose();
  const RelativeDeviation fixed = relative_deviation(ideal, kStatic),
                          moved = relative_deviation(ideal, kMotion);
  EXPECT_VEC_NEAR(fixed.position, Vec3(-2.0065875574940207e-05, -0.00997486149609908, 0.005778714826719043),
                  1e-15);
  EXPECT_VEC_NEAR(fixed.rotation,
                  Vec3(3.7450550917602644e-06, -3.63666238646505e-06, -1.3680246635918872e-06), 1e-19);
  EXPECT_VEC_NEAR(moved.position, Vec3(0.00302348993924815, -0.004677628419510931, -0.004851468982235242),
                  1e-15);
  EXPECT_VEC_NEAR(moved.rotation,
                  Vec3(8.529727342604134e-06, 1.9111557059018397e-07, -2.4457437415779593e-06), 1e-19);
  const TipAndAxis wanted = {ideal.p, ideal.R.col(2)};
  const TipAndAxis asked = corrected_pose(wanted, {fixed, moved});
  EXPECT_VEC_NEAR(asked.position, Vec3(35.49699657593633, -62.23534751008439, 48.74907275415551), 1e-12);
  EXPECT_VEC_NEAR(asked.tool_axis, Vec3(0.46984864209044247, 0.1710224938064201, 0.8660216857203983), 1e-15);
}

TEST(RelativeDeviation, TheCorrectedPoseBringsTheWantedOne) {
  // Gear and tool really displaced: T_wt = Err(w)^-1 T Err(t), with the corrected pose as T.
  const Pose ideal = ideal_pose();
  PoseDeviations all = kStatic;
  all.gear.d += kMotion.gear.d;
  all.gear.e += kMotion.gear.e;
  all.tool.d += kMotion.tool.d;
  all.tool.e += kMotion.tool.e;
  const TipAndAxis wanted = {ideal.p, ideal.R.col(2)};
  const TipAndAxis asked = corrected_pose(wanted, {relative_deviation(ideal, all)});
  const Vec3 turn = wanted.tool_axis.cross(asked.tool_axis);
  const Mat3 r = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * ideal.R;
  const auto exp = [](const Vec3& e) {
    return Eigen::AngleAxisd(e.norm(), e.normalized()).toRotationMatrix();
  };
  const Mat3 w = exp(all.gear.e), t = exp(all.tool.e);
  const Vec3 p = w.transpose() * (r * all.tool.d + asked.position - all.gear.d);
  const Vec3 axis = w.transpose() * r * t * Vec3::UnitZ();
  EXPECT_LE((p - wanted.position).norm(), 1.5e-7);  // second order of 0.015 mm and 1.3e-5 rad
  EXPECT_LE((axis - wanted.tool_axis).norm(), 2e-10);
}

TEST(RelativeDeviation, AMovedGearIsAMovedToolTheOtherWay) {
  const Pose ideal = ideal_pose();
  PoseDeviations gear, tool;
  gear.gear = {{0.01, -0.02, 0.005}, Vec3::Zero()};
  tool.tool = {ideal.R.transpose() * Vec3(-0.01, 0.02, -0.005), Vec3::Zero()};
  EXPECT_VEC_NEAR(relative_deviation(ideal, gear).position, relative_deviation(ideal, tool).position, 1e-17);
}

TEST(RelativeDeviation, ErrorsBelongToOneSide) {
  const Machine machine = machine_of(grinder::text(0));
  const auto gear = errors_of(machine, Branch::workpiece), tool = errors_of(machine, Branch::tool);
  EXPECT_EQ(gear.size() + tool.size(), 53U);
  const auto has = [](const std::vector<std::string>& names, const char* name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const char* name : {"EXX", "ECC", "EA0C", "EXw"}) EXPECT_TRUE(has(gear, name)) << name;
  for (const char* name : {"EXY", "ECA", "EC0Y", "EXt"}) EXPECT_TRUE(has(tool, name)) << name;
  EXPECT_EQ(without_errors_of(machine, Branch::tool).errors.size(), gear.size());
  EXPECT_TRUE(errors_of(without_errors_of(machine, Branch::tool), Branch::tool).empty());
}

}  // namespace
}  // namespace abbe
