#include "abbe/gear/gear_cl.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <sstream>
#include <vector>

#include "abbe/gear/test_gear_machines.h"
#include "abbe/gear/test_gears.h"

namespace abbe {
namespace {

/// A GOTO record, and whether it is a rapid.
struct Record {
  Vec3 centre, axis;
  bool rapid = false;
};

std::vector<Record> records_of(const std::string& text) {
  std::vector<Record> records;
  std::istringstream lines(text);
  bool rapid = false;
  for (std::string line; std::getline(lines, line);) {
    Record record;
    if (line == "RAPID") {
      rapid = true;
    } else if (std::sscanf(line.c_str(), "GOTO/%lf,%lf,%lf,%lf,%lf,%lf", &record.centre[0], &record.centre[1],
                           &record.centre[2], &record.axis[0], &record.axis[1], &record.axis[2]) == 6) {
      record.rapid = rapid;
      rapid = false;
      records.push_back(record);
    }
  }
  return records;
}

TEST(GearCl, EveryGapIsCutOnce) {
  for (const GearSpec& spec : {test::seed_spec(), test::helical_spec(1), test::helical_spec(-1)}) {
    const GearJob job = test::job_of(spec);
    const WheelInGap wheel = test::wheel_of(job.gear);
    std::vector<int> cut(static_cast<std::size_t>(spec.teeth), 0);
    const auto records = records_of(write_gear_cl(job, wheel, -1, 0.5 * um));
    for (std::size_t i = 1; i < records.size(); ++i) {
      const Record &a = records[i - 1], &b = records[i];
      EXPECT_NEAR(b.axis.norm(), 1, 1e-11);
      const bool deep = std::hypot(a.centre.x(), a.centre.y()) < wheel.centre_distance + 1e-6 &&
                        std::hypot(b.centre.x(), b.centre.y()) < wheel.centre_distance + 1e-6;
      if (!deep) continue;
      EXPECT_FALSE(b.rapid);
      EXPECT_GT(b.centre.z(), a.centre.z());
      if (a.centre.z() > 0 || b.centre.z() <= 0) continue;
      // Where the stroke crosses the middle of the face it is at its gap.
      const double part = -a.centre.z() / (b.centre.z() - a.centre.z());
      const Vec3 at = a.centre + part * (b.centre - a.centre);
      const double gap = std::atan2(at.y(), at.x()) / (2 * std::numbers::pi) * spec.teeth;
      EXPECT_NEAR(gap, std::round(gap), 1e-3);
      ++cut[static_cast<std::size_t>((static_cast<int>(std::round(gap)) + spec.teeth) % spec.teeth)];
    }
    for (const int times : cut) EXPECT_EQ(times, 1);
  }
}

TEST(GearCl, TheWheelStartsOutsideTheGear) {
  const GearJob job = test::job_of(test::helical_spec());
  const WheelInGap wheel = test::wheel_of(job.gear);
  const double radius = 150, tip = job.gear.tip_radius, half = 30;
  const auto records = records_of(write_gear_cl(job, wheel, -1, 0.5 * um));
  ASSERT_FALSE(records.empty());
  EXPECT_TRUE(records.front().rapid);
  for (std::size_t i = 0; i < records.size(); ++i) {
    // Rapids stay outside the tip cylinder with the whole disc, chords included.
    const Vec3& b = records[i].centre;
    if (!records[i].rapid) continue;
    EXPECT_GT(std::hypot(b.x(), b.y()) - radius, tip + 1);
    if (i == 0 || !records[i - 1].rapid) continue;
    const Vec3 middle = 0.5 * (b + records[i - 1].centre);
    EXPECT_GT(std::hypot(middle.x(), middle.y()) - radius, tip + 1);
  }
  // The first feed goes to full depth where the disc does not reach the tip cylinder above the face's end.
  const Record& first = records[1];
  EXPECT_FALSE(first.rapid);
  const double beyond = -half - first.centre.z(), depth = std::hypot(first.centre.x(), first.centre.y());
  EXPECT_GT(depth - std::sqrt(radius * radius - beyond * beyond), tip);
}

TEST(GearCl, TheTimeOfTheCutIsThatOfTheProgram) {
  const GearJob job = test::job_of(test::seed_spec());
  const WheelInGap wheel = test::wheel_of(job.gear);
  const auto records = records_of(write_gear_cl(job, wheel, -1, 0.5 * um));
  double fed = 0;
  for (std::size_t i = 1; i < records.size(); ++i)
    if (!records[i].rapid) fed += (records[i].centre - records[i - 1].centre).norm();
  CuttingMotion motion;
  motion.stroke = stroke_of(job, wheel);
  motion.approach = approach_of(job);
  motion.nodes = 2;
  const double of_a_gap = motion.time(job.cutting, 1, 0) - motion.time(job.cutting, 0, 0);
  EXPECT_NEAR(fed / job.cutting.feed, 94 * (of_a_gap - job.cutting.index_time), 1e-6);
}

TEST(GearCl, ChordsStayWithinTheTolerance) {
  GearSpec spec = test::helical_spec();
  spec.helix_crowning = 15 * um;
  const GearJob job = test::job_of(spec);
  const WheelInGap wheel = test::wheel_of(job.gear);
  const double tolerance = 0.5 * um;
  const auto records = records_of(write_gear_cl(job, wheel, -1, tolerance));
  double worst = 0;
  for (std::size_t i = 1; i < records.size(); ++i) {
    const Vec3 &a = records[i - 1].centre, &b = records[i].centre;
    if (records[i].rapid || records[i - 1].rapid) continue;
    if (std::abs(b.z()) > 32 || std::abs(a.z()) > 32) continue;
    const Vec3 middle = 0.5 * (a + b);
    const double angle = std::atan2(middle.y(), middle.x()) - job.gear.turn_per_mm * middle.z();
    const auto gap = static_cast<std::size_t>(
        std::lround(angle / (2 * std::numbers::pi) * spec.teeth + spec.teeth) % spec.teeth);
    worst = std::max(worst, (wheel_pose(job, wheel, gap, middle.z(), -1).position - middle).norm());
  }
  EXPECT_LT(worst, 1.2 * tolerance);
  EXPECT_GT(worst, 0.1 * tolerance);
}

}  // namespace
}  // namespace abbe
