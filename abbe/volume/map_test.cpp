#include "abbe/volume/map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include "abbe/chain/test_random_machine.h"
#include "abbe/core/units.h"
#include "abbe/volume/parallel.h"
#include "abbe/volume/test_volume.h"

namespace abbe {
namespace {

using test::column_machine;
using test::plan_of;
using test::question_of;

constexpr double kRounding = 1e-12;    // mm and rad, of positions up to half a metre
constexpr double kSecondOrder = 2e-7;  // mm: 20 urad squared over half a metre
constexpr double kPrinted = 6e-8;      // mm: numbers known to five decimals of a um

VolumeMap map_of(const Machine& machine, std::size_t count, ErrorModel model = ErrorModel::first_order) {
  return map_volume(plan_of(machine, model), question_of(machine, count));
}

// dx = -C0Y y, nothing else: every figure by hand.
TEST(VolumeMap, OneSquarenessByHand) {
  const Machine machine = column_machine("EC0Y = 20");
  const VolumeMap map = map_of(machine, 5);  // y = 0 100 200 300 400
  ASSERT_EQ(map.status, VolumeMap::Status::done);
  ASSERT_EQ(map.field.deviation.size(), 125U);
  const Spread& x = map.figures.component[0];
  EXPECT_NEAR(x.min, -8 * um, kRounding);
  EXPECT_NEAR(x.max, 0, kRounding);
  EXPECT_NEAR(x.mean, -4 * um, kRounding);
  EXPECT_NEAR(x.rms, 2 * um * std::sqrt(6.0), kRounding);  // mean square of 0 2 4 6 8: 24
  EXPECT_NEAR(x.percentile95, 8 * um, kRounding);
  EXPECT_NEAR(map.figures.component[1].range(), 0, kRounding);
  EXPECT_NEAR(map.figures.component[2].range(), 0, kRounding);
  EXPECT_NEAR(map.figures.length.max, 8 * um, kRounding);
  EXPECT_NEAR(map.figures.length.mean, 4 * um, kRounding);
  EXPECT_EQ(question_of(machine, 5).grid.at(map.figures.length.at)[1], 400);
  EXPECT_EQ(map.tilt.max, 0);  // location "line": a direction, no rotation of the carriage
  EXPECT_NEAR(map.accuracy.position.x(), 8 * um, kRounding);
  EXPECT_NEAR(map.accuracy.orientation.norm(), 0, kRounding);
  // The datum is the corner 0 0 0, where nothing is wrong.
  EXPECT_NEAR(map.datum.t.norm(), 0, kRounding);
  EXPECT_NEAR(map.from_datum.length.rms, map.figures.length.rms, kRounding);
}

// Of the deviation -b y along x the best rotation w about z: sum (x'^2 + y'^2) w = sum b y'^2.
TEST(VolumeMap, BestFitOfOneSquarenessByHand) {
  const VolumeMap map = map_of(column_machine("EC0Y = 20"), 5);
  const double xx = 500.0 * 500 / 8,
               yy = 400.0 * 400 / 8;  // mean squares of 5 even positions about their mean
  EXPECT_NEAR(map.fit.w.z(), 20 * urad * yy / (xx + yy), 1e-15);
  EXPECT_NEAR(map.fit.w.x(), 0, 1e-15);
  EXPECT_NEAR(map.fit.t.x(), -4 * um, kRounding);
  // What is left: (-b + w) y' along x, -w x' along y
  EXPECT_NEAR(map.fitted_accuracy.position.x(), 400 * (20 * urad - map.fit.w.z()), kRounding);
  EXPECT_NEAR(map.fitted_accuracy.position.y(), 500 * map.fit.w.z(), kRounding);
  EXPECT_LT(map.fitted.length.rms, map.figures.length.rms);
}

// Numbers worked out from the definitions for this grid: 3 x 3 x 3 points.
TEST(VolumeMap, RangesOfThreeSquarenessesAndAScale) {
  const Machine machine = column_machine("EC0Y = 20\nEB0Z = -15\nEA0Z = 10\nEXX = { poly = [0, 0.01] }");
  for (const ErrorModel model : {ErrorModel::first_order, ErrorModel::rigid}) {
    const VolumeMap map = map_of(machine, 3, model);
    const double tolerance = model == ErrorModel::rigid ? kSecondOrder : kRounding;
    EXPECT_NEAR(map.accuracy.position.x(), 17.5 * um, tolerance);
    EXPECT_NEAR(map.accuracy.position.y(), 3.0 * um, tolerance);
    EXPECT_NEAR(map.accuracy.position.z(), 0, tolerance);
    EXPECT_NEAR(map.figures.length.max, std::hypot(12.5, 3.0) * um, tolerance);
  }
}

TEST(VolumeMap, SquarenessChangesFaceDiagonalsOppositely) {
  const Machine machine = column_machine("EC0Y = 20\nEB0Z = -15\nEA0Z = 10");
  const std::vector<Diagonal> all = map_of(machine, 3).diagonals;
  ASSERT_EQ(all.size(), 10U);
  const auto change = [&](const std::string& name) {
    for (const Diagonal& d : all)
      if (name_of(d, machine) == name) return d.change;
    ADD_FAILURE() << "no diagonal " << name;
    return 0.0;
  };
  EXPECT_NEAR(change("+X +Y"), -6.24695 * um, kPrinted);
  EXPECT_NEAR(change("-X +Y"), +6.24695 * um, kPrinted);
  EXPECT_NEAR(change("+X +Y +Z"), -10.5359 * um, kPrinted);
  EXPECT_NEAR(change("-X +Y +Z"), 7.1418 * um, kPrinted);
  EXPECT_NEAR(change("+X -Y +Z"), 4.1719 * um, kPrinted);
  EXPECT_NEAR(change("+X +Y -Z"), -0.7778 * um, kPrinted);
  EXPECT_NEAR(all[0].length, std::hypot(500, 400), 1e-9);
  EXPECT_NEAR(all[0].range, 6.24695 * um, kPrinted);  // straight growth: the range is the change
  EXPECT_EQ(all[0].reversal, 0);
}

TEST(VolumeMap, DiagonalsOfFewerAxes) {
  const Machine machine = column_machine("EC0Y = 20");
  VolumeQuestion question = question_of(machine, 3);
  question.grid.positions[2] = {100};
  EXPECT_EQ(map_volume(plan_of(machine), question).diagonals.size(), 2U);
  question.grid.positions[1] = {0};
  EXPECT_EQ(map_volume(plan_of(machine), question).diagonals.size(), 0U);
}

TEST(VolumeMap, RangesDoNotDependOnTheDatum) {
  const Machine machine = column_machine("EC0Y = 20\nEAX = { poly = [3, 0.1] }");
  VolumeQuestion question = question_of(machine, 5);
  const VolumeMap here = map_volume(plan_of(machine), question);
  question.datum = {250, 200, 150};
  const VolumeMap there = map_volume(plan_of(machine), question);
  EXPECT_EQ(here.accuracy.position, there.accuracy.position);
  EXPECT_EQ(here.accuracy.orientation, there.accuracy.orientation);
  EXPECT_NE(here.from_datum.length.max, there.from_datum.length.max);
  EXPECT_NEAR(there.from_datum.component[0].range(), here.accuracy.position.x(), kRounding);
  EXPECT_NEAR(here.accuracy.orientation.x(), 50 * urad, kRounding);
}

TEST(VolumeMap, BestFitLeavesNoRigidMotion) {
  // A workpiece mounted askew is a rigid motion and nothing else.
  const Machine mounted = column_machine("EXw = 30\nEYw = -12\nEAw = 8\nEBw = -20\nECw = 15");
  const VolumeMap map = map_of(mounted, 4);
  EXPECT_GT(map.figures.length.max, 20 * um);
  EXPECT_LT(map.fitted.length.max, kRounding);
  EXPECT_LT(map.fitted_accuracy.position.norm(), kRounding);
  EXPECT_NEAR(map.fit.w.z(), -15 * urad, 1e-14);
  // What a fit left has no further fit.
  const Machine machine = column_machine("EC0Y = 20\nEXX = { poly = [0, 0.01] }\nEAZ = { poly = [0, 0.1] }");
  VolumeMap askew = map_of(machine, 4);
  for (std::size_t i = 0; i < askew.field.deviation.size(); ++i)
    askew.field.deviation[i] -= askew.fit.at(askew.field.nominal[i]);
  const Alignment again = best_fit(askew.field);
  EXPECT_LT(again.t.norm(), kRounding);
  EXPECT_LT(again.w.norm(), 1e-14);
}

TEST(VolumeMap, BestFitOfALineAndOfAPoint) {
  DeviationField field;
  for (int k = 0; k < 3; ++k) {
    field.nominal.emplace_back(100.0 * k, 0, 0);
    field.deviation.emplace_back(0.001, 0.002 * k, 0);
    field.rotation.push_back(Vec3::Zero());
  }
  const Alignment line = best_fit(field);
  EXPECT_NEAR(line.w.z(), 2e-5, 1e-15);
  EXPECT_NEAR(line.w.x(), 0, 1e-15);  // about the line itself nothing is seen
  field.nominal.resize(1);
  field.deviation.resize(1);
  field.rotation.resize(1);
  EXPECT_EQ(best_fit(field).w, Vec3::Zero());
  EXPECT_EQ(best_fit(field).t, field.deviation[0]);
  EXPECT_EQ(best_fit({}).t, Vec3::Zero());
}

TEST(Percentile, IsTheNearestRank) {
  std::vector<double> values(20);
  std::iota(values.begin(), values.end(), 1.0);
  std::shuffle(values.begin(), values.end(), std::mt19937(5));
  EXPECT_EQ(percentile(values, 0.95), 19);
  EXPECT_EQ(percentile(values, 1), 20);
  EXPECT_EQ(percentile(values, 0), 1);
  EXPECT_EQ(percentile(values, 0.5), 10);
  EXPECT_EQ(percentile({7}, 0.95), 7);
  EXPECT_EQ(percentile({}, 0.95), 0);
  // By counting, on random values.
  std::mt19937 random(3);
  for (std::size_t n = 1; n < 200; n += 13) {
    std::vector<double> v(n);
    for (double& x : v) x = static_cast<double>(random() % 50);
    const double p = percentile(v, kPercentile);
    const auto not_above = std::count_if(v.begin(), v.end(), [&](double x) { return x <= p; });
    const auto below = std::count_if(v.begin(), v.end(), [&](double x) { return x < p; });
    EXPECT_GE(static_cast<double>(not_above), 0.95 * static_cast<double>(n));
    EXPECT_LT(static_cast<double>(below), 0.95 * static_cast<double>(n));
  }
}

TEST(DeviationField, FieldIsPredictAtEveryPoint) {
  RandomMachine random(29);
  for (int round = 0; round < 12; ++round) {
    const Machine machine = random.make(3, 2, 0.02, 1e-4);
    const auto model = static_cast<ErrorModel>(round % 3);
    const Plan plan = plan_of(machine, model, {{"T1", 23.0}});
    VolumeQuestion question = question_of(machine, 3);
    const DeviationField field = deviation_field(plan, question.grid, question.circumstances);
    ASSERT_EQ(field.deviation.size(), 243U);
    for (std::size_t i = 0; i < 243; i += 7) {
      Query query;
      query.q = question.grid.at(i);
      query.tool = question.circumstances.tool;
      const Prediction p = predict(plan, query);
      EXPECT_EQ(field.deviation[i], p.deviation.position);
      EXPECT_EQ(field.extrapolated[i] != 0, !p.extrapolated.empty());
      if (model != ErrorModel::rigid) continue;
      // Rotation and tilt the other way round, from the poses.
      const Eigen::AngleAxisd turned(actual_pose(plan, query).R * nominal_pose(plan, query).R.transpose());
      EXPECT_NEAR((turned.angle() * turned.axis() - field.rotation[i]).norm(), 0, 1e-11);
      const double tilt = (p.actual.tool_axis - p.nominal.tool_axis).norm();
      EXPECT_NEAR(field.tilt[i], 2 * std::asin(tilt / 2), 1e-12);
    }
  }
}

TEST(VolumeMap, SameForAnyNumberOfThreads) {
  RandomMachine random(31);
  const Machine machine = random.make(3, 2, 0.02, 1e-4);
  const Plan plan = plan_of(machine, ErrorModel::rigid, {{"T1", 23.0}});
  VolumeQuestion question = question_of(machine, 4);
  question.circumstances.threads = 1;
  const VolumeMap one = map_volume(plan, question);
  for (const unsigned threads : {2U, 4U, 0U}) {
    question.circumstances.threads = threads;
    const VolumeMap many = map_volume(plan, question);
    EXPECT_EQ(many.figures.length.rms, one.figures.length.rms);
    EXPECT_EQ(many.figures.length.at, one.figures.length.at);
    EXPECT_EQ(many.fit.w, one.fit.w);
    EXPECT_EQ(many.field.extrapolated_names, one.field.extrapolated_names);
    ASSERT_EQ(many.budget.size(), one.budget.size());
    for (std::size_t k = 0; k < one.budget.size(); ++k) {
      EXPECT_EQ(many.budget[k].error, one.budget[k].error);
      EXPECT_EQ(many.budget[k].rms, one.budget[k].rms);
      EXPECT_EQ(many.budget[k].rms_without, one.budget[k].rms_without);
      EXPECT_EQ(many.budget[k].at, one.budget[k].at);
    }
    ASSERT_EQ(many.lost_motion.size(), one.lost_motion.size());
    for (std::size_t k = 0; k < one.lost_motion.size(); ++k)
      EXPECT_EQ(many.lost_motion[k].rms, one.lost_motion[k].rms);
  }
}

TEST(ErrorBudget, OneErrorIsTheWholeBudget) {
  for (const char* error : {"EC0Y = 20", "ECX = { poly = [2, 0.1] }", "EXX = { poly = [1, 0.02] }"}) {
    for (const ErrorModel model : {ErrorModel::first_order, ErrorModel::rigid, ErrorModel::linear}) {
      const VolumeMap map = map_of(column_machine(error), 5, model);
      ASSERT_EQ(map.budget.size(), 1U);
      EXPECT_NEAR(map.budget[0].rms, map.figures.length.rms, kRounding) << error;
      EXPECT_NEAR(map.budget[0].max, map.figures.length.max, kRounding) << error;
      EXPECT_NEAR(map.budget[0].rms_without, 0, kRounding) << error;
      EXPECT_NEAR(map.budget[0].max_tilt, map.tilt.max, 1e-14) << error;
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(map.budget[0].rms_component[c], map.figures.component[static_cast<std::size_t>(c)].rms,
                    kRounding);
    }
  }
}

TEST(ErrorBudget, LargestFirstAndWhatIsLeftWithoutIt) {
  const Machine machine = column_machine("EYY = 5\nEC0Y = 20\nEXX = 1");
  const VolumeMap map = map_of(machine, 5);
  ASSERT_EQ(map.budget.size(), 3U);
  const auto name = [&](std::size_t k) { return to_string(machine.errors[map.budget[k].error].name); };
  EXPECT_EQ(name(0), "EYY");  // 5 um everywhere; EC0Y: 8 um at most, 4.899 um rms
  EXPECT_EQ(name(1), "EC0Y");
  EXPECT_EQ(name(2), "EXX");
  EXPECT_NEAR(map.budget[0].rms, 5 * um, kRounding);
  EXPECT_NEAR(map.budget[1].max, 8 * um, kRounding);
  // EXX opposes EC0Y: without it more is left than with it.
  EXPECT_NEAR(map.budget[2].rms_without, std::sqrt(25.0 + 24.0) * um, kRounding);
  EXPECT_GT(map.budget[2].rms_without, map.figures.length.rms);
}

TEST(ErrorBudget, SinglesAddUpInTheFirstOrderModel) {
  RandomMachine random(37);
  for (int round = 0; round < 6; ++round) {
    Machine machine = random.make(3, 2, 0.02, 1e-4);
    machine.errors.resize(2);
    const Plan plan = plan_of(machine, ErrorModel::first_order, {{"T1", 23.0}});
    const VolumeMap map = map_volume(plan, question_of(machine, 3));
    // Without one of two errors the other one is left.
    EXPECT_NEAR(map.budget[0].rms_without, map.budget[1].rms, 1e-10);
    EXPECT_NEAR(map.budget[1].rms_without, map.budget[0].rms, 1e-10);
  }
}

TEST(LostMotion, IsForwardMinusBackward) {
  const Machine machine = column_machine(
      "EXX = { forward = { poly = [0.5] }, backward = { poly = [-1.5] } }\n"
      "EYZ = { forward = { poly = [0, 0.01] }, backward = 0 }\nEZY = 4");
  const VolumeMap map = map_of(machine, 3);
  ASSERT_EQ(map.lost_motion.size(), 2U);
  EXPECT_EQ(machine.axis(map.lost_motion[0].axis).name, "X");
  EXPECT_NEAR(map.lost_motion[0].max, 2 * um, kRounding);
  EXPECT_NEAR(map.lost_motion[0].rms, 2 * um, kRounding);
  EXPECT_EQ(machine.axis(map.lost_motion[1].axis).name, "Z");
  EXPECT_NEAR(map.lost_motion[1].max, 3 * um, kRounding);
  // The map itself is of the mean: -0.5 um along x.
  EXPECT_NEAR(map.figures.component[0].mean, -0.5 * um, kRounding);
  // Along +X +Y the lost motion of X shows with the cosine; it is no change of length.
  EXPECT_NEAR(map.diagonals[0].reversal, 2 * um * 500 / std::hypot(500, 400), kRounding);
  EXPECT_NEAR(map.diagonals[0].change, 0, kRounding);
}

TEST(VolumeMap, StopsWhenAsked) {
  const Machine machine = column_machine("EC0Y = 20\nEXX = 1");
  std::size_t total = 0, calls = 0;
  VolumeQuestion question = question_of(machine, 15);
  question.circumstances.threads = 1;
  const Plan plan = plan_of(machine);
  EXPECT_EQ(map_volume(plan, question,
                       [&](std::uint64_t done, std::uint64_t all) {
                         EXPECT_LE(done, all);
                         total = all;
                         ++calls;
                         return true;
                       })
                .status,
            VolumeMap::Status::done);
  EXPECT_EQ(total, 3 * 7 * kFieldChunk);  // 3375 points in 7 chunks; the field and two errors
  EXPECT_EQ(calls, 21U);
  for (const std::size_t last : {std::size_t{1}, std::size_t{7}, std::size_t{12}}) {
    calls = 0;
    const VolumeMap map =
        map_volume(plan, question, [&](std::uint64_t, std::uint64_t) { return ++calls < last; });
    EXPECT_EQ(map.status, VolumeMap::Status::stopped);
    EXPECT_TRUE(map.field.deviation.empty());
    EXPECT_TRUE(map.budget.empty());
    EXPECT_EQ(calls, last);
  }
}

TEST(VolumeMap, TooLargeNumbersAreAStatus) {
  const Machine machine = column_machine("EXX = { poly = [0, 0, 1e300] }");
  VolumeQuestion question = question_of(machine, 3);
  question.grid.positions[0] = {0, 1e200};
  EXPECT_EQ(map_volume(plan_of(machine), question).status, VolumeMap::Status::overflow);
  // Finite deviations of which the squares are not, and a volume as large.
  EXPECT_EQ(map_of(column_machine("EXX = { poly = [0, 1e170] }"), 3).status, VolumeMap::Status::overflow);
  const Machine perfect = column_machine("EYY = 1");
  question = question_of(perfect, 3);
  question.grid.positions[0] = {-1e170, 0, 1e170};
  const VolumeMap vast = map_volume(plan_of(perfect), question);
  EXPECT_EQ(vast.status, VolumeMap::Status::done);
  EXPECT_NEAR(vast.fitted.length.max, 0, kRounding);
  EXPECT_TRUE(vast.fit.w.allFinite());
  EXPECT_EQ(vast.diagonals.size(), 2U);  // those of Y and Z
}

TEST(VolumeMap, PointsBeyondATableAreCounted) {
  const Machine machine = column_machine("EXX = { table = [[0, 0], [250, 2]] }");
  const VolumeMap map = map_of(machine, 3);  // 0 250 500
  EXPECT_EQ(map.extrapolated, 9U);
  EXPECT_EQ(map.field.extrapolated_names, std::vector<std::string>{"EXX"});
}

TEST(ForEachChunk, DoesEachOnceAndHandsFailuresOver) {
  for (const unsigned threads : {1U, 3U}) {
    std::vector<int> times(1000, 0);
    EXPECT_TRUE(for_each_chunk(times.size(), threads, [&](std::size_t k) { ++times[k]; }));
    EXPECT_EQ(std::count(times.begin(), times.end(), 1), 1000);
    EXPECT_TRUE(for_each_chunk(0, threads, [](std::size_t) { FAIL(); }));
    EXPECT_THROW(static_cast<void>(for_each_chunk(100, threads,
                                                  [](std::size_t k) {
                                                    if (k == 50) throw std::bad_alloc();
                                                  })),
                 std::bad_alloc);
  }
}

}  // namespace
}  // namespace abbe
