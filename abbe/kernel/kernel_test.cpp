// All kernels against the general walk, on random machines.

#include "abbe/kernel/kernel.h"

#include <gtest/gtest.h>

#include <array>
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
  return setting;
}

TEST(Kernels, TipsOfAllKernelsAreTheGeneralTips) {
  RandomMachine random(11);
  int compared = 0;
  for (int round = 0; round < 60; ++round) {
    const Machine machine = random.make(3, 2, 0.05, 2e-4);
    for (const ErrorModel model : {ErrorModel::rigid, ErrorModel::linear}) {
      const Plan plan = std::get<Plan>(make_plan(machine, {}, model));
      const auto flat = FlatPlan::make(plan);
      if (flat == nullptr) continue;
      std::vector<Query> queries;
      const Query first = random.query(machine);
      for (int i = 0; i < 21; ++i) {
        queries.push_back(i % 7 < 3 ? first : random.query(machine));
        queries.back().tool = first.tool;
      }
      const Batch batch(queries, flat->view().axis_count);
      for (const Kernel* kernel : kernels()) {
        for (const std::size_t count : {std::size_t{1}, std::size_t{5}, queries.size()}) {
          std::array<std::vector<double>, 3> tip;
          for (auto& column : tip) column.assign(count, -1);
          const std::array<double*, 3> to = {tip[0].data(), tip[1].data(), tip[2].data()};
          std::vector<unsigned char> lanes(count, Lane::ordinary);
          kernel->tips(flat->view(), setting_of(first), batch.pointers.data(), count, to.data(), lanes.data());
          for (std::size_t i = 0; i < count; ++i) {
            bool outside = false;
            const Vec3 expected = actual_tip(plan, queries[i], &outside);
            const Vec3 found(tip[0][i], tip[1][i], tip[2][i]);
            ASSERT_LE((found - expected).norm(), kSameTip) << kernel->name << " round " << round;
            ASSERT_EQ(lanes[i] == Lane::outside, outside) << kernel->name;
            ++compared;
          }
        }
      }
    }
  }
  EXPECT_GT(compared, 1000);
}

}  // namespace
}  // namespace abbe::kernel
