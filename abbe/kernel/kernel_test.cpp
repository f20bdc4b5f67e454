// All kernels against the general walk, on random machines.

#include "abbe/kernel/kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "abbe/chain/correct.h"
#include "abbe/chain/predict.h"
#include "abbe/chain/test_random_machine.h"
#include "abbe/kernel/flat_plan.h"
#include "abbe/kernel/tip_function.h"

namespace abbe::kernel {
namespace {

constexpr double kSameTip = 2e-11;  // mm, at positions of up to some metres

std::vector<const Kernel*> kernels() {
  std::vector<const Kernel*> all;
  for (const char* name : {"baseline", "avx2", "avx512"})
    if (const Kernel* kernel = named(name)) all.push_back(kernel);
  return all;
}

/// Queries as arrays by axis.
struct Batch {
  std::vector<std::vector<double>> q;
  std::vector<const double*> pointers;

  Batch(const std::vector<Query>& queries, int axes) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(axes); ++i) {
      std::vector<double>& column = q.emplace_back();
      for (const Query& query : queries) column.push_back(query.q[i]);
    }
    for (const auto& column : q) pointers.push_back(column.data());
  }
};

Setting setting_of(const Query& query) {
  Setting setting;
  for (int k = 0; k < 3; ++k) {
    setting.tip[k] = query.tool.tip[k];
    setting.axis[k] = query.tool.axis[k];
  }
  std::copy(query.approach.begin(), query.approach.end(), setting.approach);
  return setting;
}

const Environment kWarm = {{"T1", 23.5}};

Plan plan_of(const Machine& machine, ErrorModel model) {
  return std::get<Plan>(make_plan(machine, kWarm, model));
}

/// Only the errors that are tabulated.
Machine tabulated(Machine machine) {
  std::vector<ErrorTerm> kept;
  for (const ErrorTerm& error : machine.errors) {
    Machine one = machine;
    one.errors = {error};
    if (FlatPlan::make(plan_of(one, ErrorModel::rigid)) != nullptr) kept.push_back(error);
  }
  machine.errors = kept;
  return machine;
}

TEST(Kernels, TipsOfAllKernelsAreTheGeneralTips) {
  RandomMachine random(11);
  int compared = 0, beyond = 0;
  for (int round = 0; round < 30; ++round) {
    const Machine machine = tabulated(random.make(3, round % 3, 0.05, 2e-4));
    for (const ErrorModel model : {ErrorModel::rigid, ErrorModel::linear}) {
      const Plan plan = plan_of(machine, model);
      const auto flat = FlatPlan::make(plan);
      ASSERT_NE(flat, nullptr);
      std::vector<Query> queries;
      const Query first = random.query(machine);
      for (int i = 0; i < 21; ++i) {
        // Near each other, apart, and far beyond tables and travels.
        queries.push_back(i < 9 ? first : random.query(machine, i % 4 == 0 ? 3000 : 300));
        queries.back().tool = first.tool;
        queries.back().approach = first.approach;
        queries.back().q[0] += 0.001 * i;
      }
      const Batch batch(queries, flat->view().axis_count);
      for (const Kernel* kernel : kernels()) {
        for (const std::size_t count : {std::size_t{1}, std::size_t{2}, std::size_t{5}, queries.size()}) {
          std::array<std::vector<double>, 3> tip;
          for (auto& column : tip) column.assign(count, -1);
          const std::array<double*, 3> to = {tip[0].data(), tip[1].data(), tip[2].data()};
          std::vector<unsigned char> lanes(count, Lane::ordinary);
          kernel->tips(flat->view(), first.tool.tip.data(), first.approach.data(), batch.pointers.data(), count, to.data(), lanes.data());
          for (std::size_t i = 0; i < count; ++i) {
            bool outside = false;
            const Vec3 expected = actual_tip(plan, queries[i], &outside);
            const Vec3 found(tip[0][i], tip[1][i], tip[2][i]);
            ASSERT_LE((found - expected).norm(), kSameTip) << kernel->name << " round " << round;
            Vec3 one;
            unsigned char lane = Lane::ordinary;
            kernel->one_tip(flat->view(), first.tool.tip.data(), first.approach.data(), queries[i].q.data(), one.data(),
                            &lane);
            ASSERT_LE((one - expected).norm(), kSameTip) << kernel->name << " round " << round;
            ASSERT_EQ(lane, lanes[i]);
            ASSERT_EQ(lanes[i] == Lane::outside, outside) << kernel->name;
            ++compared;
            beyond += outside ? 1 : 0;
          }
        }
      }
    }
  }
  EXPECT_GT(compared, 1000);
  EXPECT_GT(beyond, 100);
}

TEST(Kernels, TipFunctionIsTheGeneralTip) {
  RandomMachine random(12);
  for (int round = 0; round < 20; ++round) {
    // With and without functions that no kernel knows.
    const Machine whole = random.make(3, 0, 0.05, 2e-4);
    const Plan plan = plan_of(round % 2 == 0 ? tabulated(whole) : whole, ErrorModel::rigid);
    const TipFunction tip(plan);
    Query a = random.query(plan.machine()), b = random.query(plan.machine());
    b.tool = a.tool;
    b.approach = a.approach;
    EXPECT_LE((tip(a, nullptr) - actual_tip(plan, a)).norm(), kSameTip);
    Query both = a;
    const auto two = tip.two(both, {0, 1, 2}, Vec3(a.q[0], a.q[1], a.q[2]), Vec3(b.q[0], b.q[1], b.q[2]), nullptr);
    EXPECT_LE((two.a - actual_tip(plan, a)).norm(), kSameTip);
    EXPECT_LE((two.b - actual_tip(plan, b)).norm(), kSameTip);
  }
}

/// What a step leaves is a small part of it, and many steps leave nothing.
TEST(Kernels, CorrectPosesConvergesToTheCorrection) {
  RandomMachine random(13);
  int ordinary_lanes = 0, fine = 0, slow = 0;
  for (int round = 0; round < 40; ++round) {
    const Machine machine = tabulated(random.make(3, round % 3, 0.02, 1e-4));
    const Plan plan = plan_of(machine, ErrorModel::rigid);
    const auto flat = FlatPlan::make(plan);
    ASSERT_NE(flat, nullptr);
    const AxisSet free = (AxisSet{1} << machine.axis_count()) - 1;
    ASSERT_TRUE(corrects(flat->view(), free));
    std::vector<Query> queries;
    for (int i = 0; i < 21; ++i) {
      queries.push_back(random.query(machine, 200, 1.2));
      queries.back().tool = queries.front().tool;
      queries.back().approach = queries.front().approach;
    }
    const Batch batch(queries, machine.axis_count());
    Setting setting = setting_of(queries.front());
    setting.free = free;
    for (const Kernel* kernel : kernels()) {
      for (const int steps : {1, 2, 8}) {
        const std::size_t count = steps == 2 ? 1 : queries.size();
        setting.exact_steps = steps;
        std::vector<std::vector<double>> q(static_cast<std::size_t>(machine.axis_count()),
                                           std::vector<double>(count));
        std::vector<double*> to;
        for (auto& column : q) to.push_back(column.data());
        std::vector<double> last(count);
        std::vector<unsigned char> lanes(count, Lane::ordinary);
        kernel->correct_poses(flat->view(), setting, batch.pointers.data(), count, to.data(), last.data(),
                              lanes.data());
        for (std::size_t i = 0; i < count; ++i) {
          const Correction expected = correct(plan, queries[i], free, {});
          if ((lanes[i] & Lane::unusual) != 0 || expected.status != Status::ok) continue;
          ++ordinary_lanes;
          double rest = 0;
          for (std::size_t k = 0; k < q.size(); ++k) {
            const bool rotary = (flat->view().rotary >> k & 1) != 0;
            rest = std::max(rest, std::abs(q[k][i] - expected.corrected[k]) * (rotary ? 300 : 1));
          }
          ASSERT_LE(rest, 0.3 * last[i] + 1e-8) << kernel->name << " round " << round;
          if (steps == 8 && rest > 1e-8) ++slow;
          if (steps == 1 && rest < 1e-6) ++fine;
        }
      }
    }
  }
  EXPECT_GT(ordinary_lanes, 500);
  EXPECT_GT(fine, ordinary_lanes / 5);
  EXPECT_LT(slow, ordinary_lanes / 50);  // near singular poses
}

TEST(Kernels, KernelsAreFoundByName) {
  EXPECT_NE(named("baseline"), nullptr);
  EXPECT_EQ(named("none"), nullptr);
  EXPECT_EQ(named(best().name), &best());
}

}  // namespace
}  // namespace abbe::kernel
