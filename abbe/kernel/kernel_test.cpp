// All kernels against the general walk, on random machines.

#include "abbe/kernel/kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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
/// First-order corrections in double precision, mm (rotary ones count 300 mm per rad).
constexpr double kSameStep = 1e-8;
/// Commands after one exact step, mm (rotary ones count 300 mm per rad).
constexpr double kSameExact = 1e-8;
/// What single precision may change in a first-order correction, as a part of its length and of the ways by
/// which its rotary axes move the tip, which the linear axes take back.
constexpr double kSingleStep = 1e-6;
/// And what its error functions may miss besides, mm: each 1e-8 mm and 3e-11 rad, and there are several. The
/// worst seen on 6000 machines was 3.3e-8.
constexpr double kSingleFunctions = 1e-7;

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

/// What correct_poses says about `count` poses of a batch from `first` on.
struct Results {
  std::vector<std::vector<double>> q;
  std::vector<double> last;
  std::vector<unsigned char> lanes;

  Results(const Kernel& kernel, const FlatView& view, const Setting& setting, const Batch& batch,
          std::size_t first, std::size_t count)
      : q(batch.q.size(), std::vector<double>(count)), last(count), lanes(count, Lane::ordinary) {
    std::vector<const double*> from;
    for (const double* column : batch.pointers) from.push_back(column + first);
    std::vector<double*> to;
    for (auto& column : q) to.push_back(column.data());
    kernel.correct_poses(view, setting, from.data(), count, to.data(), last.data(), lanes.data());
  }
};

/// The length of a correction and of what its rotary part moves by tips within `reach` of the rotary axes,
/// mm.
double way_of(const FlatView& view, const Results& results, std::size_t i, const Query& from, double reach) {
  double way = results.last[i];
  for (std::size_t k = 0; k < results.q.size(); ++k)
    if ((view.rotary >> k & 1) != 0) way += reach * std::abs(results.q[k][i] - from.q[k]);
  return way;
}

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

/// Constants only: all twists between two motions become one, across the translations between them.
Machine constant(Machine machine) {
  std::erase_if(machine.errors, [](const ErrorTerm& error) { return !error.function.is_constant(); });
  return machine;
}

/// Near each other, apart, and far beyond tables and travels; one tool and direction of approach.
std::vector<Query> mixed_queries(RandomMachine& random, const Machine& machine) {
  std::vector<Query> queries;
  const Query first = random.query(machine, 200, 1.2);
  for (int i = 0; i < 21; ++i) {
    queries.push_back(i < 9 ? first : random.query(machine, i % 4 == 0 ? 3000 : 200, 1.2));
    queries.back().tool = first.tool;
    queries.back().approach = first.approach;
    queries.back().q[0] += 0.001 * i;
  }
  return queries;
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
      for (const Query& query : mixed_queries(random, machine)) {
        bool outside = false;
        const Vec3 expected = actual_tip(plan, query, &outside);
        for (const Kernel* kernel : kernels()) {
          Vec3 tip;
          unsigned char lane = Lane::ordinary;
          kernel->one_tip(flat->view(), query.tool.tip.data(), query.approach.data(), query.q.data(),
                          tip.data(), &lane);
          ASSERT_LE((tip - expected).norm(), kSameTip) << kernel->name << " round " << round;
          ASSERT_EQ(lane == Lane::outside, outside) << kernel->name;
          ++compared;
          beyond += outside ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(compared, 1000);
  EXPECT_GT(beyond, 100);
}

TEST(Kernels, NeighboursTogetherAreTheGeneralTips) {
  RandomMachine random(14);
  int beyond = 0;
  for (int round = 0; round < 60; ++round) {
    const Machine machine = tabulated(random.make(3, round % 3, 0.05, 2e-4));
    const Plan plan = plan_of(machine, ErrorModel::rigid);
    const TipFunction together(plan);
    Query query = random.query(machine, 200, 1.2);
    std::array<std::size_t, 3> axes{};
    for (int i = 0, found = 0; i < machine.axis_count() && found < 3; ++i)
      if (machine.axis(i).type == AxisType::linear)
        axes[static_cast<std::size_t>(found++)] = static_cast<std::size_t>(i);
    std::swap(axes[0], axes[2]);
    std::vector<Vec3> at;
    for (int i = 0; i < 1 + round % 8; ++i) at.push_back(random.vector(round % 4 == 0 ? 3000 : 200));
    std::array<TipAt, TipFunction::kMost> tips;
    ASSERT_TRUE(together.neighbours(query, axes, at, tips));
    for (std::size_t i = 0; i < at.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) query.q[axes[k]] = at[i][static_cast<Eigen::Index>(k)];
      bool outside = false;
      ASSERT_LE((tips[i].tip - actual_tip(plan, query, &outside)).norm(), kSameTip) << "round " << round;
      ASSERT_EQ(tips[i].outside, outside);
      beyond += outside ? 1 : 0;
    }
  }
  EXPECT_GT(beyond, 10);
}

TEST(Kernels, TipFunctionIsTheGeneralTip) {
  RandomMachine random(12);
  for (int round = 0; round < 20; ++round) {
    // With and without functions that no kernel knows.
    const Machine whole = random.make(3, 0, 0.05, 2e-4);
    const Plan plan = plan_of(round % 2 == 0 ? tabulated(whole) : whole, ErrorModel::rigid);
    const TipFunction tip(plan);
    const Query query = random.query(plan.machine());
    EXPECT_LE((tip(query, nullptr) - actual_tip(plan, query)).norm(), kSameTip);
  }
}

/// The first-order step is that of Method::one_step; what a Newton step leaves is a small part of it, and
/// many steps leave nothing.
TEST(Kernels, CorrectPosesIsTheOneStepAndConvergesToTheCorrection) {
  RandomMachine random(13);
  int ordinary_lanes = 0, fine = 0, slow = 0, beyond = 0;
  for (int round = 0; round < 40; ++round) {
    const Machine whole = random.make(3, round % 3, 0.02, 1e-4);
    const Machine machine = round % 4 == 3 ? constant(whole) : tabulated(whole);
    const Plan plan = plan_of(machine, ErrorModel::rigid);
    const auto flat = FlatPlan::make(plan);
    ASSERT_NE(flat, nullptr);
    const AxisSet free = (AxisSet{1} << machine.axis_count()) - 1;
    ASSERT_TRUE(corrects(flat->view(), free));
    const std::vector<Query> queries = mixed_queries(random, machine);
    const Batch batch(queries, machine.axis_count());
    Setting setting = setting_of(queries.front());
    setting.free = free;
    CorrectOptions options;
    options.target_shift = random.vector(0.01);
    for (int k = 0; k < 3; ++k) setting.shift[k] = options.target_shift[k];
    for (const Kernel* kernel : kernels()) {
      for (const int steps : {0, 1, 2, 8}) {
        const std::size_t count = steps == 2 ? 1 : queries.size();
        setting.exact_steps = steps;
        options.method = steps == 0 ? Method::one_step : Method::newton;
        const Results results(*kernel, flat->view(), setting, batch, 0, count);
        const auto& [q, last, lanes] = results;
        for (std::size_t i = 0; i < count; ++i) {
          if (steps == 0) {
            bool outside = false;
            static_cast<void>(actual_tip(plan, queries[i], &outside));
            ASSERT_EQ((lanes[i] & Lane::outside) != 0, outside) << kernel->name << " round " << round;
            beyond += outside ? 1 : 0;
          }
          const Correction expected = correct(plan, queries[i], free, options);
          if ((lanes[i] & Lane::unusual) != 0 || expected.status != Status::ok) continue;
          ++ordinary_lanes;
          double rest = 0;
          for (std::size_t k = 0; k < q.size(); ++k) {
            const bool rotary = (flat->view().rotary >> k & 1) != 0;
            rest = std::max(rest, std::abs(q[k][i] - expected.corrected[k]) * (rotary ? 300 : 1));
          }
          const double most =
              steps == 0 ? kSingleStep * way_of(flat->view(), results, i, queries[i], 6000) + kSingleFunctions
                         : 0.3 * last[i] + kSameStep;
          ASSERT_LE(rest, most) << kernel->name << " round " << round;
          if (steps == 8 && rest > kSameStep) ++slow;
          if (steps == 1 && rest < 1e-6) ++fine;
        }
      }
    }
  }
  EXPECT_GT(ordinary_lanes, 500);
  EXPECT_GT(fine, ordinary_lanes / 8);
  EXPECT_LT(slow, ordinary_lanes / 50);  // near singular poses
  EXPECT_GT(beyond, 100);
}

/// Neighbouring poses, some at rest, some turning back: what batches compute in single precision.
std::vector<Query> path_queries(RandomMachine& random, const Machine& machine) {
  const Query a = random.query(machine, 200, 1.2), b = random.query(machine, 200, 1.2);
  std::vector<Query> queries(67, a);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const double s = std::sin(0.05 * static_cast<double>(i));
    for (std::size_t k = 0; k < a.q.size(); ++k) queries[i].q[k] += s * 0.02 * (b.q[k] - a.q[k]);
  }
  return queries;
}

std::vector<const FlatTable*> tables_of(const FlatView& view) {
  std::vector<const FlatTable*> tables;
  for (std::uint32_t k = 0; k < view.actual_count; ++k) {
    if (view.actual[k].group < 0) continue;
    const FlatGroup& group = view.groups[view.actual[k].group];
    for (std::uint32_t i = 0; i < group.table_count; ++i) tables.push_back(&group.tables[i]);
  }
  return tables;
}

/// Only the errors that have no sines: these are polynomials inside the travels only, and single precision
/// stops there, before the ends of other functions.
Machine without_waves(Machine machine) {
  Machine one = machine;
  std::erase_if(machine.errors, [&one](const ErrorTerm& error) {
    one.errors = {error};
    const auto flat = FlatPlan::make(plan_of(one, ErrorModel::rigid));
    const auto tables = tables_of(flat->view());
    return std::any_of(tables.begin(), tables.end(),
                       [](const FlatTable* table) { return std::isfinite(table->waves_hi); });
  });
  return machine;
}

/// Where the first function of this axis ends that is held beyond its end; infinite if none is.
double first_end(const FlatView& view, int axis) {
  double end = std::numeric_limits<double>::infinity();
  for (const FlatTable* table : tables_of(view))
    if (table->axis == axis) end = std::min(end, table->hi);
  return end;
}

/// Up to and over the end of a function that is held beyond it, if there is one, in small steps and in such
/// that single precision hardly sees; the end is at every place of a packet in turn.
std::vector<Query> queries_to_an_end(RandomMachine& random, const Machine& machine, const FlatView& view,
                                     int round) {
  std::vector<Query> queries(67, random.query(machine, 20, 0.2));
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const double end = first_end(view, axis);
    if (!std::isfinite(end)) continue;
    const double unit = (view.rotary >> axis & 1) != 0 ? 1e-2 : 1;  // rad, mm
    const double step = unit * (round % 3 == 0 ? 1e-3 : 1e-6);
    const int last_inside = 40 + round % 16;
    for (int i = 0; i < 67; ++i)
      queries[static_cast<std::size_t>(i)].q[static_cast<std::size_t>(axis)] = end + step * (i - last_inside);
    break;
  }
  return queries;
}

/// Batches begin in single precision, single poses do not: a first-order step keeps its bound, and an exact
/// step after it leaves only rounding of it.
TEST(Kernels, BatchesInSinglePrecisionAreTheFirstOrderStep) {
  RandomMachine random(14);
  int over_an_end = 0;
  std::array<int, 2> single_lanes{}, lanes_seen{};  // on paths, at ends
  for (int round = 0; round < 180; ++round) {
    const Machine known = tabulated(random.make(3, round % 3, 0.02, 1e-4));
    const Machine machine = round < 120 ? known : without_waves(known);
    const auto flat = FlatPlan::make(plan_of(machine, ErrorModel::rigid));
    ASSERT_NE(flat, nullptr);
    const std::vector<Query> queries =
        round < 120 ? path_queries(random, machine) : queries_to_an_end(random, machine, flat->view(), round);
    const Batch batch(queries, machine.axis_count());
    Setting setting = setting_of(queries.front());
    setting.free = (AxisSet{1} << machine.axis_count()) - 1;
    const Vec3 shift = random.vector(0.01);
    for (int k = 0; k < 3; ++k) setting.shift[k] = shift[k];
    setting.exact_steps = round % 2;
    for (const Kernel* kernel : kernels()) {
      const Results all(*kernel, flat->view(), setting, batch, 0, queries.size());
      for (std::size_t i = 0; i < queries.size(); ++i) {
        const Results one(*kernel, flat->view(), setting, batch, i, 1);
        ASSERT_EQ(all.lanes[i], one.lanes[0]) << kernel->name << " round " << round;
        over_an_end += round >= 120 && (one.lanes[0] & Lane::outside) != 0 ? 1 : 0;
        if ((one.lanes[0] & Lane::unusual) != 0) continue;
        double rest = setting.exact_steps == 0 ? std::abs(all.last[i] - one.last[0]) : 0;
        for (std::size_t k = 0; k < all.q.size(); ++k) {
          const bool rotary = (flat->view().rotary >> k & 1) != 0;
          rest = std::max(rest, std::abs(all.q[k][i] - one.q[k][0]) * (rotary ? 300 : 1));
        }
        const double way = way_of(flat->view(), one, 0, queries[i], 1000);
        const double most = setting.exact_steps == 0 ? kSingleStep * way + kSingleFunctions : kSameExact;
        ASSERT_LE(rest, most) << kernel->name << " round " << round;
        if (setting.exact_steps == 0) {
          const std::size_t where = round < 120 ? 0 : 1;
          single_lanes[where] += rest > 1e-11 ? 1 : 0;
          lanes_seen[where] += kernel->width > 2 ? 1 : 0;
        }
      }
    }
  }
  for (const std::size_t where : {0U, 1U}) EXPECT_GE(single_lanes[where], lanes_seen[where] / 4) << where;
  EXPECT_GT(over_an_end, 500);
}

TEST(Kernels, KernelsAreFoundByName) {
  EXPECT_NE(named("baseline"), nullptr);
  EXPECT_EQ(named("none"), nullptr);
  EXPECT_EQ(named(best().name), &best());
}

}  // namespace
}  // namespace abbe::kernel
