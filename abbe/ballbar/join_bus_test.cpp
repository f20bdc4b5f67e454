#include "abbe/ballbar/join_bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace abbe {
namespace {

using ::testing::HasSubstr;

constexpr double kRadius = 80, kStep = 1e-3, kOmega = 0.4;  // mm, s, rad/s
constexpr double kLag = 0.03;                               // s, of the first axis; the other has none

/// In from outside, run-in, the runs one after the other with a halt between, and out again.
struct Drives {
  BusRecord record;
  double now = 0;
  Vec3 centre = Vec3::Zero();

  void point(double x, double y, double lagging_x) {
    record.time.push_back(now);
    record.commanded[0].push_back(centre.z() + x);
    record.commanded[1].push_back(centre.x() + y);
    record.actual[0].push_back(centre.z() + lagging_x);
    record.actual[1].push_back(centre.x() + y);
    now += kStep;
  }
  void rest(double x, double y, int samples) {
    for (int i = 0; i < samples; ++i) point(x, y, x);
  }
  void go(double from, double to) {
    const double sense = to > from ? 1 : -1;
    for (double a = from; sense * (to - a) > 0; a += sense * kOmega * kStep)
      point(kRadius * std::cos(a), kRadius * std::sin(a), kRadius * std::cos(a - sense * kOmega * kLag));
  }
};

/// Plane ZX about (5, 0, -7): the first axis is Z.
Drives both_ways() {
  Drives drives;
  drives.centre = Vec3(5, 0, -7);
  for (int i = 0; i < 200; ++i) drives.point(kRadius + 2 - 0.01 * i, 0, kRadius);
  drives.rest(kRadius, 0, 50);
  drives.go(-1, 7);
  drives.rest(kRadius * std::cos(7.0), kRadius * std::sin(7.0), 50);
  drives.go(7, -1);
  drives.rest(kRadius * std::cos(-1.0), kRadius * std::sin(-1.0), 50);
  return drives;
}

BallbarTest trace(std::vector<int> directions) {
  BallbarTest test;
  test.file = "zx.csv";
  test.plane = {2, 0};
  test.radius = kRadius;
  test.feed = kRadius * kOmega;
  test.centre = Vec3(5, 0, -7);
  for (const int direction : directions) {
    BallbarRun run;
    run.direction = direction;
    for (int i = 0; i <= 300; ++i) run.angle.push_back((direction > 0 ? i : 300 - i) * 2 * M_PI / 300);
    run.deviation.assign(run.angle.size(), 0.0);
    test.runs.push_back(run);
  }
  return test;
}

// The commanded point of a sample stands at its angle; the actual one lags behind in the direction of the
// run.
TEST(JoinBus, JoinedPositionsAreThoseOfTheAngle) {
  const BallbarTest test = trace({+1, -1});
  const auto answer = join_bus(test, both_ways().record);
  ASSERT_TRUE(std::holds_alternative<BallbarTest>(answer)) << std::get<JoinTrouble>(answer).message;
  const auto& joined = std::get<BallbarTest>(answer);
  for (const BallbarRun& run : joined.runs) {
    ASSERT_EQ(run.commanded.size(), run.angle.size());
    for (std::size_t i = 0; i < run.angle.size(); ++i) {
      const double a = run.angle[i];
      EXPECT_LT((run.commanded[i] - (test.centre + kRadius * radial_direction(test.plane, a))).norm(), 1e-6);
      EXPECT_NEAR(run.actual[i].z(), -7 + kRadius * std::cos(a - run.direction * kOmega * kLag), 1e-6);
      EXPECT_NEAR(run.actual[i].x(), 5 + kRadius * std::sin(a), 1e-6);
      EXPECT_EQ(run.actual[i].y(), 0);
    }
  }
}

TEST(JoinBus, RunsKeepTheirDirection) {
  const auto refused = join_bus(trace({-1, +1}), both_ways().record);
  ASSERT_TRUE(std::holds_alternative<JoinTrouble>(refused));
  EXPECT_THAT(std::get<JoinTrouble>(refused).message, HasSubstr("counter-clockwise along run 2"));
}

/// The same drives on a bus with `times` samples for each command; in between, actual positions move on.
BusRecord on_a_faster_bus(const BusRecord& slow, int times) {
  BusRecord fast;
  for (std::size_t i = 0; i + 1 < slow.time.size(); ++i)
    for (int j = 0; j < times; ++j) {
      const double part = static_cast<double>(j) / times;
      fast.time.push_back(slow.time[i] + part * (slow.time[i + 1] - slow.time[i]));
      for (int k = 0; k < 2; ++k) {
        fast.commanded[k].push_back(slow.commanded[k][i]);
        fast.actual[k].push_back(slow.actual[k][i] + part * (slow.actual[k][i + 1] - slow.actual[k][i]));
      }
    }
  return fast;
}

// The halts between the runs are no runs, however often the bus repeats them.
TEST(JoinBus, RepeatedCommandsCountOnce) {
  const BallbarTest test = trace({+1, -1});
  const BusRecord record = both_ways().record;
  const auto expected = std::get<BallbarTest>(join_bus(test, record));
  const auto answer = join_bus(test, on_a_faster_bus(record, 4));
  ASSERT_TRUE(std::holds_alternative<BallbarTest>(answer)) << std::get<JoinTrouble>(answer).message;
  const auto& joined = std::get<BallbarTest>(answer);
  for (std::size_t r = 0; r < joined.runs.size(); ++r)
    for (std::size_t i = 0; i < joined.runs[r].angle.size(); ++i) {
      EXPECT_LT((joined.runs[r].commanded[i] - expected.runs[r].commanded[i]).norm(), 1e-9);
      EXPECT_LT((joined.runs[r].actual[i] - expected.runs[r].actual[i]).norm(), 1e-9);
    }
}

TEST(JoinBus, WhatIsNoRecordOfThisTestIsRefused) {
  const BallbarTest test = trace({+1});
  const auto why = [&](const BallbarTest& t, const BusRecord& record) {
    const auto answer = join_bus(t, record);
    return std::holds_alternative<JoinTrouble>(answer) ? std::get<JoinTrouble>(answer).why : "joined";
  };
  const BusRecord good = both_ways().record;
  EXPECT_EQ(why(test, good), "joined");
  BallbarTest other = test;
  other.centre.x() += 1;
  EXPECT_NE(why(other, good), "joined") << "it only crosses that circle";
  other = test;
  other.radius = 100;
  EXPECT_THAT(why(other, good), HasSubstr("never on that circle"));
  BusRecord swapped = good;
  std::swap(swapped.commanded[0], swapped.commanded[1]);
  EXPECT_NE(why(test, swapped), "joined");
  BusRecord broken = good;
  broken.actual[1].pop_back();
  EXPECT_THAT(why(test, broken), HasSubstr("nothing can be looked up"));
  broken = good;
  broken.commanded[0][77] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(why(test, broken), HasSubstr("nothing can be looked up"));
  EXPECT_THAT(why(test, {}), HasSubstr("nothing can be looked up"));
  broken = good;
  broken.time[78] = broken.time[77];
  EXPECT_THAT(why(test, broken), HasSubstr("nothing can be looked up"));
  // A record that ends half way round.
  BusRecord half = good;
  for (auto* column : {&half.time, &half.commanded[0], &half.commanded[1], &half.actual[0], &half.actual[1]})
    column->resize(9000);
  EXPECT_THAT(why(test, half), HasSubstr("in their order"));
}

}  // namespace
}  // namespace abbe
