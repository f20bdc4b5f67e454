#include "abbe/chain/control_kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "abbe/core/units.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

constexpr double kLength = 87.5;

Machine machine_of(const char* text) {
  const auto machine = read_machine({"test.toml", text}, std::nullopt, {});
  EXPECT_TRUE(machine.value) << (machine.diagnostics.empty() ? "" : machine.diagnostics.front().message);
  return *machine.value;
}

// A tilting table A that carries a table C; words A and C are right-handed turns of the tables.
const char* const kTiltingTable = R"(
format = 1
[machine]
chain = "w C A b Y X Z t"
[axis.A]
direction = [1, 0, 0]
origin = [10, 25, -90]
[axis.C]
direction = [0, 0, 1]
origin = [10, 20, -60]
[tool]
length = 87.5
)";

Vec3 about_x(double a, const Vec3& v) {
  return {v.x(), std::cos(a) * v.y() - std::sin(a) * v.z(), std::sin(a) * v.y() + std::cos(a) * v.z()};
}
Vec3 about_z(double c, const Vec3& v) {
  return {std::cos(c) * v.x() - std::sin(c) * v.y(), std::sin(c) * v.x() + std::cos(c) * v.y(), v.z()};
}

// joints = Rx(a) (Rz(c) (P - R) - o) + o + R: the switchable kinematics xyzac-trt of LinuxCNC, P the point
// with the tool offset in it, R a point of the axis of C, o the way from there to the axis of A plus the tool
// length along Z.
TEST(ControlKinematics, TcpOfATiltingTableIsTheFormulaOfItsDesigners) {
  const Machine machine = machine_of(kTiltingTable);
  const ControlKinematics control(machine, addressed_axes(machine));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> turn(-3, 3), place(-200, 200);
  const Vec3 R(10, 20, -90), o(0, 5, kLength);  // R at the height of the axis of A
  for (int i = 0; i < 200; ++i) {
    const double a = turn(random), c = turn(random);
    const Vec3 point(place(random), place(random), place(random));
    const auto map = control.axes_of_points({a, 0, c}, kLength);
    ASSERT_TRUE(map);
    const Vec3 joints = about_x(a, about_z(c, point - R) - o) + o + R;
    EXPECT_LT(((*map)(point)-joints).norm(), 1e-9);
  }
}

TEST(ControlKinematics, PointsAndAxesAreInverse) {
  const Machine machine = machine_of(kTiltingTable);
  const ControlKinematics control(machine, addressed_axes(machine));
  const auto map = control.axes_of_points({0.3, 0, -1.1}, kLength);
  ASSERT_TRUE(map);
  const auto back = inverse(*map);
  ASSERT_TRUE(back);
  const Vec3 point(12, -34, 56);
  EXPECT_LT(((*back)((*map)(point)) - point).norm(), 1e-10);
  // at home a point is the axis command
  EXPECT_LT(((*control.axes_of_points({}, kLength))(point)-point).norm(), 1e-10);
}

TEST(ControlKinematics, TheTipStaysWhereTheTableTurnsBelowIt) {
  const Machine machine = machine_of(kTiltingTable);
  const ControlKinematics control(machine, addressed_axes(machine));
  const Tool tool = tool_of(machine, kLength);
  const Vec3 point(5, 6, 7);
  const Vec3 tip = control.pose(point, {}, tool).position;
  for (const Turns turns : {Turns{0.2, 0, 0}, Turns{0, 0, 2}, Turns{-1, 0, 0.5}}) {
    const Vec3 axes = (*control.axes_of_points(turns, kLength))(point);
    EXPECT_LT((control.pose(axes, turns, tool).position - tip).norm(), 1e-9);
  }
}

TEST(ControlKinematics, UsesTheControlsOwnNumbers) {
  std::string text = kTiltingTable;
  text += "[control]\nmode = \"tcp\"\n[control.axis.A]\norigin = [10, 25.1, -90]\n[errors]\nEXX = 5\n";
  const Machine machine = machine_of(text.c_str());
  const ControlKinematics control(machine, addressed_axes(machine));
  EXPECT_TRUE(control.believed().errors.empty());
  const Machine as_built = machine_of(kTiltingTable);
  const ControlKinematics built(as_built, addressed_axes(as_built));
  const Turns turns{0.5, 0, 0};
  const Vec3 difference = (*control.axes_of_points(turns, kLength))(Vec3::Zero()) -
                          (*built.axes_of_points(turns, kLength))(Vec3::Zero());
  // a centre that is 0.1 mm off moves the tip by (1 - R) 0.1
  const Vec3 off(0, 0.1, 0);
  EXPECT_LT((difference - (off - about_x(0.5, off))).norm(), 1e-9);
}

}  // namespace
}  // namespace abbe
