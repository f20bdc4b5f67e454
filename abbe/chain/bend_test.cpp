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

Vec3 error_at(const Plan& plan, const Query& query) {
  return actual_tip(plan, query) - nominal_tip(plan, query);
}

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
  machine.errors[0].function =
      ErrorFunction::product({*ErrorFunction::polynomial(0, {0, 1}), *ErrorFunction::polynomial(1, {0, 1})});
  EXPECT_EQ(straight_reach(std::get<Plan>(make_plan(machine, kWarm)), tool_of(machine), 1e-3), 0);
}

/// "w b X Y Z t" with travels of 10 mm and one error of X.
Machine small_machine(const char* name, ErrorFunction function) {
  Machine machine;
  machine.units = FileUnits{1, 1, 1, 1};
  for (int k = 0; k < 3; ++k) {
    Body body;
    body.name = body.address = std::string(1, "XYZ"[k]);
    body.direction = Vec3::Unit(k);
    body.range = {-10, 10};
    body.order = line_order();
    body.axis = k;
    machine.bodies.push_back(body);
    machine.axes.push_back(k);
    machine.variables.push_back({Variable::Kind::position, body.name, k});
  }
  ErrorTerm term;
  term.name = *read_error_name(name);
  term.function = std::move(function);
  machine.errors.push_back(term);
  return machine;
}

TEST(Bend, FarMeasuringPointsLengthenTheLever) {
  // The displacement was measured 2 m above: the tip moves by 1.5e-6 sin(x / mm) 2 m.
  Machine machine = small_machine("EBX", *ErrorFunction::sine(0, 1.5e-6, 1.0, 0));
  machine.bodies[0].measured_at = Vec3(0, 0, 2000);
  const Plan plan = std::get<Plan>(make_plan(machine, {}));
  const double bend = 1e-4;
  const double reach = straight_reach(plan, tool_of(machine), bend);
  ASSERT_GT(reach, 0);
  double worst = 0;
  for (double x = -9; x + reach <= 10; x += 0.1) {
    Query from, to, middle;
    from.tool = to.tool = middle.tool = tool_of(machine);
    from.q[0] = x, to.q[0] = x + reach, middle.q[0] = x + reach / 2;
    worst =
        std::max(worst, (error_at(plan, middle) - (error_at(plan, from) + error_at(plan, to)) / 2).norm());
  }
  EXPECT_LE(worst, bend);
  EXPECT_GT(worst, bend / 4);
}

TEST(Bend, AStepHasNoReach) {
  // Two positions that are one in double arithmetic: 3 um at once.
  const Machine machine =
      small_machine("EYX", *ErrorFunction::table(0, {-10, 5, 5 + 2e-15, 10}, {0, 0, 0.003, 0.003},
                                                 ErrorFunction::Interpolation::linear));
  EXPECT_EQ(straight_reach(std::get<Plan>(make_plan(machine, {})), tool_of(machine), 1e-3), 0);
}

}  // namespace
}  // namespace abbe
