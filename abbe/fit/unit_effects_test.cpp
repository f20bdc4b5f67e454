#include "abbe/fit/unit_effects.h"

#include <gtest/gtest.h>

#include <variant>

#include "abbe/machine/error_body.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

constexpr double kRounding = 1e-12;  // mm or rad per unit, of levers below a metre

const char* const kMachines[] = {
    "chain = \"w X b Y Z t\"\n[axis.X]\nerrors_seen = \"tool\"\nmeasured_at = [0, 30, 80]\n[tool]\norigin = "
    "[1, 2, "
    "500]\nlength = 150\n[workpiece]\norigin = [5, 6, 7]\n",
    "chain = \"w C b X Y Z B t\"\n[axis.C]\ndirection = [0, 0, 1]\norigin = [10, 20, 0]\n[axis.B]\ndirection "
    "= [0, 1, "
    "0]\norigin = [0, 0, 600]\n[tool]\norigin = [0, 0, 500]\nlength = 150\n",
};

std::vector<Query> some_queries() {
  std::vector<Query> out(3);
  out[1].q = {120, -80, 40, 0.3, -0.2};
  out[1].tool.tip = Vec3(10, -20, 300);
  out[2].q = {-300, 250, -90, -1, 2};
  out[2].tool.tip = Vec3(-40, 0, 410);
  return out;
}

Machine machine_of(const char* text) {
  return *read_machine({"m.toml", std::string("format = 1\n[machine]\n") + text}, std::nullopt, {}).value;
}

TEST(UnitEffects, AffineEffectsAreThePredictions) {
  for (const char* text : kMachines) {
    const Machine machine = machine_of(text);
    const std::vector<std::string> names = {"EXX", "EYX", "EAX", "EBY", "ECZ", "EC0Y", "EA0Z", "EXt"};
    const auto effects = UnitEffects::make(machine, names);
    ASSERT_TRUE(effects);
    for (std::size_t k = 0; k < names.size(); ++k) {
      const Plan plan = std::get<Plan>(
          make_plan(*with_unit_error(machine, *read_error_name(names[k])), {}, ErrorModel::first_order));
      for (const Query& query : some_queries()) {
        const Prediction expected = predict(plan, query);
        const Twist found = effects->at(k, query);
        EXPECT_LT((found.d - expected.deviation.position).norm(), kRounding * 1000) << text << names[k];
        const Vec3 rotation = nominal_pose(plan, query).R * expected.tool_twist.e;
        EXPECT_LT((found.e - rotation).norm(), kRounding) << text << names[k];
      }
    }
  }
}

TEST(UnitEffects, EffectsAddUpToThePrediction) {
  for (const char* text : kMachines) {
    const Machine machine = machine_of(text);
    const Machine with_errors =
        machine_of((std::string(text) + "[errors]\nEXX = 3\nEBX = -7\nECZ = 11\nEC0Y = 5\n").c_str());
    const Plan plan = std::get<Plan>(make_plan(with_errors, {}, ErrorModel::first_order));
    const auto effects = UnitEffects::make(machine, {"EXX", "EBX", "ECZ", "EC0Y"});
    ASSERT_TRUE(effects);
    for (const Query& query : some_queries()) {
      const Vec3 sum = 3e-3 * effects->at(0, query).d - 7e-6 * effects->at(1, query).d +
                       11e-6 * effects->at(2, query).d + 5e-6 * effects->at(3, query).d;
      EXPECT_LT((sum - predict(plan, query).deviation.position).norm(), kRounding) << text;
    }
  }
}

TEST(UnitEffects, NumbersBeyondDoubleAreNone) {
  const auto effects = UnitEffects::make(machine_of(kMachines[0]), {"EBX"});
  Query far;
  far.q.fill(1e308);
  far.tool.tip.setConstant(1e308);
  EXPECT_TRUE(effects->at(0, far).d.isZero(0));
}

}  // namespace
}  // namespace abbe
