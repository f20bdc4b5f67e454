#include "abbe/verify/tool_direction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "abbe/chain/test_plan.h"
#include "abbe/core/units.h"
#include "abbe/verify/rotary.h"

namespace abbe::verifying {
namespace {

using abbe::testing::plan_of;

constexpr double kExact = 1e-9;

Rotary rotary(const std::string& chain, const std::string& axes) {
  return Rotary(plan_of("format = 1\n[machine]\nchain = \"" + chain + "\"\n" + axes +
                        "[control]\nmode = \"tcp\"\nvectors = { turns = \"nearest\" }\n")
                    .machine());
}
Rotary table(const std::string& range = "") {
  return rotary("w C A b X Y Z t", "[axis.A]\ndirection = [1, 0, 0]\norigin = [0, 20, -90]\n" + range +
                                       "[axis.C]\ndirection = [0, 0, 1]\n");
}

// v = (sin c sin a, cos c sin a, cos a): A30 C40 gives (0.321394, 0.383022, 0.866025)
TEST(ToolDirection, OfATiltingTable) {
  const auto found =
      table().direction().turns_for(Vec3(0.321393805, 0.383022222, 0.866025404), {25 * deg, 0, 30 * deg});
  ASSERT_EQ(found.problem, nullptr) << found.problem;
  EXPECT_NEAR(found.turns[0] / deg, 30, 1e-6);
  EXPECT_NEAR(found.turns[2] / deg, 40, 1e-6);
}

// v = (cos c sin b, sin c sin b, cos b): B25 C-70 gives (0.144544, -0.397131, 0.906308)
TEST(ToolDirection, OfAHead) {
  const Rotary head =
      rotary("w b X Y Z C B t", "[axis.B]\ndirection = [0, 1, 0]\n[axis.C]\ndirection = [0, 0, 1]\n");
  const auto found =
      head.direction().turns_for(2 * Vec3(0.144543958, -0.397131262, 0.906307787), {0, 20 * deg, -60 * deg});
  ASSERT_EQ(found.problem, nullptr) << found.problem;
  EXPECT_NEAR(found.turns[1] / deg, 25, 1e-6);
  EXPECT_NEAR(found.turns[2] / deg, -70, 1e-6);
}

TEST(ToolDirection, OfEveryStructureTheModelTellsBack) {
  struct Structure {
    const char *chain, *axes;
    std::size_t tilt, turn;
  };
  const char* const ac = "[axis.A]\ndirection = [1, 0, 0]\n[axis.C]\ndirection = [0, 0, 1]\n";
  const char* const bc = "[axis.B]\ndirection = [0, 1, 0]\n[axis.C]\ndirection = [0, 0, 1]\n";
  const Structure structures[] = {
      {"w C A b Y X Z t", ac, 0, 2},
      {"w C B b X Y Z t", bc, 1, 2},
      {"w b X Y Z C B t", bc, 1, 2},
      {"w b X Y Z C A t", ac, 0, 2},
      {"w C b X Y Z B t", bc, 1, 2},
      {"w C b X Y Z B t", "[axis.B]\ndirection = [0, 1, 1]\n[axis.C]\ndirection = [0, 0, -1]\n", 1, 2}};
  for (const Structure& structure : structures) {
    const Rotary machine = rotary(structure.chain, structure.axes);
    for (const double tilt : {12.0, 40.0, 75.0}) {
      for (const double turn : {-200.0, 0.0, 130.0, 400.0}) {
        Turns meant{}, from{};
        meant[structure.tilt] = tilt * deg;
        meant[structure.turn] = turn * deg;
        from[structure.tilt] = (tilt - 3) * deg;
        from[structure.turn] = (turn + 8) * deg;
        const Vec3 v = machine.kinematics()
                           .pose(Vec3::Zero(), meant, tool_of(machine.kinematics().believed(), 0))
                           .tool_axis;
        const auto found = machine.direction().turns_for(v, from);
        ASSERT_EQ(found.problem, nullptr) << structure.chain << " " << found.problem;
        for (std::size_t k = 0; k < 3; ++k)
          EXPECT_NEAR(found.turns[k], meant[k], kExact) << structure.chain << " " << tilt << " " << turn;
      }
    }
  }
}

TEST(ToolDirection, WhatIsNotClearHasAProblem) {
  const Vec3 leaning(0, std::sin(30 * deg), std::cos(30 * deg));  // A30 C0 or A-30 C180
  EXPECT_NE(table().direction().turns_for(leaning, {5 * deg, 0, 140 * deg}).problem, nullptr);
  EXPECT_EQ(table("range = [-5, 100]\n").direction().turns_for(leaning, {5 * deg, 0, 140 * deg}).problem,
            nullptr);
  EXPECT_NE(table("range = [-5, 20]\n").direction().turns_for(leaning, {}).problem, nullptr);
  EXPECT_NE(table().direction().turns_for(Vec3(0, 1e-5, 1), {0, 0, 1}).problem, nullptr) << "the pole";
  const auto pole = table().direction().turns_for(Vec3::UnitZ(), {0.3, 0, 1});
  EXPECT_EQ(pole.problem, nullptr);
  EXPECT_NEAR(pole.turns[2], 1, kExact) << "C stays";
  EXPECT_NEAR(pole.turns[0], 0, kExact);
}

}  // namespace
}  // namespace abbe::verifying
