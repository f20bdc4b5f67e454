#include "abbe/chain/bend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "abbe/chain/predict.h"
#include "abbe/chain/test_random_machine.h"

namespace abbe {
namespace {

const Environment kWarm = {{"T1", 23.5}};

Machine with_tabulated_errors(RandomMachine& random) {
  Machine machine = random.make(3, 0, 0.02, 1e-4);
  std::vector<ErrorTerm> kept;
  for (const ErrorTerm& error : machine.errors) {
    Machine one = machine;
    one.errors = {error};
    const Plan plan = std::get<Plan>(make_plan(one, kWarm));
    if (straight_reach(plan, tool_of(machine), 1e-3) > 0) kept.push_back(error);
  }
  machine.errors = kept;
  return machine;
}

Vec3 error_at(const Plan& plan, const Query& query) { return actual_tip(plan, query) - nominal_tip(plan, query); }

TEST(Bend, ErrorsBendNoMoreThanTheBound) {
  RandomMachine random(41);
  int looked = 0;
  double closest = 0;
  for (int round = 0; round < 30; ++round) {
    const Machine machine = with_tabulated_errors(random);
    const Plan plan = std::get<Plan>(make_plan(machine, kWarm));
    const Tool tool = tool_of(machine);
    for (const double bend : {1e-4, 1e-3}) {
      const double reach = straight_reach(plan, tool, bend);
      ASSERT_GT(reach, 0);
      ASSERT_TRUE(std::isfinite(reach));
      for (int line = 0; line < 60; ++line) {
        Query a = random.query(machine, 480), b = a, middle = a;
        const Vec3 way = random.unit() * reach;
        for (std::size_t k = 0; k < 3; ++k) b.q[k] += way[static_cast<Eigen::Index>(k)];
        const Vec3 from = error_at(plan, a), to = error_at(plan, b);
        for (const double s : {0.25, 0.5, 0.75}) {
          for (std::size_t k = 0; k < 3; ++k) middle.q[k] = a.q[k] + s * (b.q[k] - a.q[k]);
          const double off = (error_at(plan, middle) - ((1 - s) * from + s * to)).norm();
          EXPECT_LE(off, bend) << "round " << round;
          closest = std::max(closest, off / bend);
          ++looked;
        }
      }
    }
  }
  EXPECT_GT(looked, 1000);
  EXPECT_GT(closest, 0.02);  // the bound is not empty
}

TEST(Bend, WhatIsNotTabulatedHasNoReach) {
  RandomMachine random(42);
  Machine machine = with_tabulated_errors(random);
  ASSERT_FALSE(machine.errors.empty());
  machine.errors[0].function = ErrorFunction::product(
      {*ErrorFunction::polynomial(0, {0, 1}), *ErrorFunction::polynomial(1, {0, 1})});
  EXPECT_EQ(straight_reach(std::get<Plan>(make_plan(machine, kWarm)), tool_of(machine), 1e-3), 0);
}

}  // namespace
}  // namespace abbe
