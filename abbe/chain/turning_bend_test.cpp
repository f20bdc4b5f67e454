#include "abbe/chain/turning_bend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "abbe/chain/predict.h"
#include "abbe/chain/test_random_machine.h"

namespace abbe {
namespace {

const Environment kWarm = {{"T1", 23.5}};

Machine with_known_errors(RandomMachine& random) {
  Machine machine = random.make(3, 2, 0.02, 1e-4);
  std::vector<ErrorTerm> kept;
  for (const ErrorTerm& error : machine.errors) {
    Machine one = machine;
    one.errors = {error};
    const Plan plan = std::get<Plan>(make_plan(one, kWarm));
    if (std::isfinite(TurningBend(plan, tool_of(machine)).bound(EvenMove{}).position)) kept.push_back(error);
  }
  machine.errors = kept;
  return machine;
}

Query at(const Query& like, const std::array<double, kMaxAxes>& from, const std::array<double, kMaxAxes>& to,
         double t) {
  Query query = like;
  for (std::size_t k = 0; k < kMaxAxes; ++k) query.q[k] = from[k] + t * (to[k] - from[k]);
  return query;
}

struct Off {
  Vec3 position, direction;
};

Off off(const Plan& plan, const Query& like, const EvenMove& move, double t) {
  const Pose done = actual_pose(plan, at(like, move.done_from, move.done_to, t));
  const Pose meant = nominal_pose(plan, at(like, move.meant_from, move.meant_to, t));
  return {done.p - meant.p, done.R * like.tool.axis - meant.R * like.tool.axis};
}

TEST(TurningBend, MovesBendNoMoreThanTheBound) {
  RandomMachine random(61);
  int looked = 0;
  double closest = 0, closest_direction = 0;
  for (int round = 0; round < 8; ++round) {
    const Machine machine = with_known_errors(random);
    const Plan plan = std::get<Plan>(make_plan(machine, kWarm));
    const TurningBend bend(plan, tool_of(machine));
    for (int line = 0; line < 80; ++line) {
      const double reach = std::pow(10, random.uniform(-2, 1)), turn = std::pow(10, random.uniform(-4, -0.7));
      const double shift = std::pow(10, random.uniform(-4, -1)), lean = shift * 1e-3;
      const Query a = random.query(machine, 440);
      EvenMove move;
      for (std::size_t k = 0; k < static_cast<std::size_t>(machine.axis_count()); ++k) {
        const bool rotary = machine.axis(static_cast<int>(k)).type == AxisType::rotary;
        const double way = rotary ? turn : reach, by = rotary ? lean : shift;
        move.meant_from[k] = a.q[k];
        move.meant_to[k] = a.q[k] + random.uniform(-way, way);
        move.done_from[k] = move.meant_from[k] + random.uniform(-by, by);
        move.done_to[k] = move.meant_to[k] + random.uniform(-by, by);
      }
      const TurningBend::Bound bound = bend.bound(move);
      if (!std::isfinite(bound.position)) continue;
      const Off from = off(plan, a, move, 0), to = off(plan, a, move, 1);
      for (const double t : {0.2, 0.5, 0.8}) {
        const Off inside = off(plan, a, move, t);
        const double position = (inside.position - ((1 - t) * from.position + t * to.position)).norm();
        const double direction = (inside.direction - ((1 - t) * from.direction + t * to.direction)).norm();
        EXPECT_LE(position, bound.position + 1e-9) << "round " << round << " line " << line;
        EXPECT_LE(direction, bound.direction + 1e-12) << "round " << round << " line " << line;
        closest = std::max(closest, position / bound.position);
        closest_direction = std::max(closest_direction, direction / bound.direction);
        ++looked;
      }
    }
  }
  EXPECT_GT(looked, 500);
  EXPECT_GT(closest, 0.01);  // the bound is not empty
  EXPECT_GT(closest_direction, 0.01);
}

TEST(TurningBend, WhatIsNotTabulatedIsNotKnown) {
  RandomMachine random(62);
  Machine machine = with_known_errors(random);
  ASSERT_FALSE(machine.errors.empty());
  machine.errors[0].function =
      ErrorFunction::product({*ErrorFunction::polynomial(0, {0, 1}), *ErrorFunction::polynomial(1, {0, 1})});
  const TurningBend bend(std::get<Plan>(make_plan(machine, kWarm)), tool_of(machine));
  EXPECT_FALSE(std::isfinite(bend.bound(EvenMove{}).position));
}

}  // namespace
}  // namespace abbe
