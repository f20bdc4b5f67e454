// The expansion of a workpiece as errors of the chain (abbe/machine/expansion.h), by the chain itself.

#include "abbe/machine/expansion.h"

#include <gtest/gtest.h>

#include <variant>

#include "abbe/chain/correct.h"
#include "abbe/chain/expanded_prediction.h"
#include "abbe/chain/plan.h"
#include "abbe/chain/predict.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

constexpr double kNanometre = 1e-6;  // mm: squares of the strain

Machine machine_of(const std::string& text) {
  return read_machine({"m.toml", "format = 1\n[machine]\n" + text}, std::nullopt, {}).value.value();
}

/// 11.5 ppm/K at 30 degC: 115 um per m.
constexpr WorkpieceExpansion kWarm{30, 11.5e-6};

const char* const kChains[] = {
    "chain = \"w b X Y Z t\"\n[tool]\norigin = [1, 2, 300]\nlength = 100\n[workpiece]\norigin = [10, -20, "
    "30]\n",
    "chain = \"w X Y b Z t\"\n[axis.X]\norigin = [5, 6, 7]\nerrors_seen = \"tool\"\n[axis.Y]\nerrors_seen = "
    "\"body\"\n[tool]\norigin = [1, 2, 300]\n[workpiece]\norigin = [10, -20, 30]\n",
    "chain = \"w C A b X Y Z S t\"\n[axis.C]\ndirection = [0, 0, 1]\norigin = [3, 4, -50]\nerrors_seen = "
    "\"tool\"\n[axis.A]\ndirection = [1, 0, 0]\norigin = [0, 9, -40]\nerrors_seen = \"body\"\n[tool]\norigin "
    "= [0, 0, "
    "300]\nlength = 80\n[workpiece]\norigin = [3, 4, -20]\n",
};

std::vector<std::array<double, kMaxAxes>> some_poses() {
  return {{0.3, -0.4, 120, -80, 40}, {100, 50, -30, 20, 10}, {-2, 1, 30, 200, -60}, {}};
}

TEST(Expansion, DeviationIsProportionalToThePlace) {
  for (const char* chain : kChains) {
    const Machine cold = machine_of(chain);
    const auto warm = with_expansion(cold, kWarm);
    ASSERT_TRUE(std::holds_alternative<Machine>(warm)) << chain;
    const Plan plan = std::get<Plan>(make_plan(std::get<Machine>(warm), {}));
    for (const auto& q : some_poses()) {
      Query query;
      query.q = q;
      query.tool = tool_of(cold);
      const Prediction p = predict(plan, query);
      EXPECT_LT((p.deviation.position + kWarm.strain() * p.nominal.position).norm(), kNanometre) << chain;
      EXPECT_LT(p.deviation.tool_axis.norm(), 1e-15);
    }
  }
}

TEST(Expansion, ExpandedPredictionAgreesWithTheChain) {
  for (const char* chain : kChains) {
    const Machine cold = machine_of(chain);
    const Plan ideal = std::get<Plan>(make_plan(cold, {})),
               warm = std::get<Plan>(make_plan(std::get<Machine>(with_expansion(cold, kWarm)), {}));
    for (const auto& q : some_poses()) {
      Query query;
      query.q = q;
      query.tool = tool_of(cold);
      const Prediction a = expanded(predict(ideal, query), nominal_pose(ideal, query), kWarm),
                       b = predict(warm, query);
      EXPECT_LT((a.deviation.position - b.deviation.position).norm(), kNanometre) << chain;
      EXPECT_LT((a.actual.position - b.actual.position).norm(), kNanometre) << chain;
      EXPECT_LT((a.tool_twist.d - b.tool_twist.d).norm(), kNanometre) << chain;
    }
  }
}

TEST(Expansion, TurningTheToolDoesNotMatter) {
  const Machine machine = machine_of(
      "chain = \"w C b X Y Z B t\"\n[axis.C]\ndirection = [0, 0, 1]\n[axis.B]\ndirection = [0, 1, 0]\norigin "
      "= "
      "[0, 0, 400]\n[tool]\norigin = [0, 0, 350]\nlength = 80\n");
  ASSERT_TRUE(std::holds_alternative<std::string>(with_expansion(machine, kWarm)));
  const Plan plan = std::get<Plan>(make_plan(machine, {}));
  for (const auto& q : some_poses()) {
    Query query;
    query.q = q;
    query.tool = tool_of(machine);
    const Prediction p = expanded(predict(plan, query), nominal_pose(plan, query), kWarm);
    EXPECT_LT((p.deviation.position + kWarm.strain() * p.nominal.position).norm(), 1e-12);
    EXPECT_EQ(p.deviation.tool_axis.norm(), 0);
    // Asked for the place on the warm part, the tip is at the drawing's when that has cooled.
    const Vec3 drawing(30, -20, 50), cooled = expanded(drawing, kWarm) / (1 + kWarm.strain());
    EXPECT_LT((cooled - drawing).norm(), 1e-12);
  }
}

TEST(Expansion, WarmPartIsCutLarger) {
  // X = 100 mm from the origin of the work: 11.5 um further out at 30 degC, less far at 10 degC.
  const Machine cold = machine_of("chain = \"w b X Y Z t\"\n");
  for (const double T : {30.0, 10.0}) {
    const auto warm = with_expansion(cold, {T, 11.5e-6});
    const Plan plan = std::get<Plan>(make_plan(std::get<Machine>(warm), {}));
    Query query;
    query.q = {100, 0, 0};
    const Correction corrected = correct(plan, query, *free_axes(cold, 0), CorrectOptions{});
    EXPECT_NEAR(corrected.corrected[0] - 100, T > 20 ? 11.5 * um : -11.5 * um, 2 * kNanometre);
  }
}

TEST(Expansion, TwentyDegreesChangeNothing) {
  const Machine cold = machine_of(kChains[1]);
  EXPECT_EQ(std::get<Machine>(with_expansion(cold, {20, 11.5e-6})).errors.size(), cold.errors.size());
}

TEST(Expansion, ChainsWhereItCannotActAreRefused) {
  const char* const heads[] = {
      "chain = \"w b X Y Z A t\"\n[tool]\nlength = 100\n",
      "chain = \"w b X Y Z t\"\n[axis.X]\norder = [\"motion\"]\n",
      "chain = \"w C b X Y Z t\"\n[axis.C]\ndirection = [0, 0, 1]\norder = [\"static\", "
      "\"motion\"]\n[workpiece]\norigin "
      "= [5, 0, 0]\n",
  };
  for (const char* head : heads)
    EXPECT_TRUE(std::holds_alternative<std::string>(with_expansion(machine_of(head), kWarm))) << head;
}

}  // namespace
}  // namespace abbe
