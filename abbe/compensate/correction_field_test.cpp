#include "abbe/compensate/correction_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "abbe/chain/predict.h"
#include "abbe/chain/test_plan.h"

namespace abbe {
namespace {

constexpr const char* kBent = R"(format = 1
[machine]
chain = "w b X Y Z t"
[tool]
length = 60.0
[axis.X]
range = [0, 1000]
[axis.Y]
[axis.Z]
[errors]
EXX = { table = [[0, 0], [300, 12], [500, -20], [1000, 8]] }
EBX = { poly = [0, 4e-2] }
EYX = { forward = { poly = [3, 0, 1e-4] }, backward = { poly = [-3, 0, 1e-4] } }
EZY = { poly = [0, 2e-2] }
EC0Y = 20.0
)";

using Approach = std::array<signed char, 3>;

class LookAhead : public ::testing::Test {
 protected:
  Plan plan_ = testing::plan_of(kBent);
  CorrectionField field_{plan_, addressed_axes(plan_.machine()), false};

  /// |tip_actual(q) - tip_nominal(m)| with the tool in use, mm.
  [[nodiscard]] double rest(const Vec3& m, const Vec3& q, const Approach& approach) const {
    Query query;
    query.tool = tool_of(plan_.machine());
    std::copy_n(q.data(), 3, query.q.begin());
    std::copy(approach.begin(), approach.end(), query.approach.begin());
    Query nominal = query;
    std::copy_n(m.data(), 3, nominal.q.begin());
    return (actual_tip(plan_, query) - nominal_pose(plan_, nominal).p).norm();
  }
};

// Steps that were begun together end where single ones do, in whatever order they are asked for; and the
// answer is the correction, not only the same.
TEST_F(LookAhead, AnswersAreTheCorrectionWhateverWasLookedAt) {
  std::mt19937 random(5);
  const auto number = [&](double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random);
  };
  Vec3 m(400, 100, -50);
  double largest = 0;
  for (int round = 0; round < 2000; ++round) {
    const double step = round % 7 == 0 ? 100 : 1;
    std::array<Vec3, 8> points;
    for (Vec3& point : points) {
      m += Vec3(number(-step, step), number(-step, step), number(-step, step));
      m.x() = std::clamp(m.x(), 1.0, 999.0);
      point = m;
    }
    const Approach looked = {static_cast<signed char>(round % 3 - 1), 1, 0};
    field_.look_ahead(std::span(points).first(round % 9), looked);
    if (round % 5 == 0) std::shuffle(points.begin(), points.end(), random);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Approach approach = round % 4 == 0 && i > 3 ? Approach{1, -1, 0} : looked;
      const Vec3 asked = i == 5 && round % 2 == 0 ? Vec3(points[i] + Vec3(0.1, 0, 0)) : points[i];
      const auto answer = field_.at(asked, 0, approach);
      ASSERT_EQ(answer.trouble, CorrectionField::Trouble::none);
      ASSERT_LT(rest(asked, answer.q, approach), 21 * nm) << round << ' ' << i;
      largest = std::max(largest, (answer.q - asked).norm());
    }
  }
  EXPECT_GT(largest, 10 * um);
}

// What was looked at with another tool or another place of the datum is forgotten.
TEST_F(LookAhead, ANewToolForgetsIt) {
  const std::array<Vec3, 3> points = {Vec3(200, 0, 0), Vec3(201, 0, 0), Vec3(202, 0, 0)};
  field_.look_ahead(points, {});
  Tool longer = tool_of(plan_.machine());
  longer.tip = 3 * longer.tip;
  field_.set_tool(longer);
  const Vec3 with_it = field_.at(points[1]).q;
  CorrectionField fresh(plan_, addressed_axes(plan_.machine()), false);
  fresh.set_tool(longer);
  EXPECT_LT((with_it - fresh.at(points[1]).q).norm(), 1 * nm);
  CorrectionField other(plan_, addressed_axes(plan_.machine()), false);
  EXPECT_GT((with_it - other.at(points[1]).q).norm(), 0.5 * um);
}

// An axis that is withheld keeps its command, whatever was looked at.
TEST_F(LookAhead, WithheldAxesAreNotMovedByIt) {
  const std::array<Vec3, 3> points = {Vec3(200, 0, 0), Vec3(201, 0, 0), Vec3(202, 0, 0)};
  field_.look_ahead(points, {});
  EXPECT_EQ(field_.at(points[1], 1).q.x(), 201.0);
}

}  // namespace
}  // namespace abbe
