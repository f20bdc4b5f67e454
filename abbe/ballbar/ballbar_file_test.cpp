#include "abbe/ballbar/ballbar_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "abbe/core/units.h"

namespace abbe {
namespace {

using ::testing::HasSubstr;

std::string table(int first, int step, int count, const std::string& more = "") {
  std::string text;
  for (int i = 0; i < count; ++i)
    text += std::to_string(first + i * step) + "," + std::to_string(i % 5) + more + "\n";
  return text;
}

const std::string kKeys = "# plane: XY\n# radius_mm: 100\n# feed_mm_per_min: 1200\n";
const std::string kHeader = "angle_deg,deviation_um\n";

std::string codes(const Parsed<BallbarTest>& read) {
  std::string out;
  for (const Diagnostic& d : read.diagnostics) out += d.code + " " + d.message + "; ";
  return out;
}

TEST(BallbarFile, PlainTableWithKeys) {
  const auto read = read_ballbar("a.csv", kKeys + kHeader + table(0, 10, 37));
  ASSERT_TRUE(read.value) << codes(read);
  EXPECT_EQ(read.value->plane, (TestPlane{0, 1}));
  EXPECT_EQ(read.value->radius, 100);
  EXPECT_NEAR(read.value->feed, 20, 1e-12);
  ASSERT_EQ(read.value->runs.size(), 1U);
  EXPECT_EQ(read.value->runs[0].direction, +1);
  EXPECT_NEAR(read.value->runs[0].angle[1], 10 * deg, 1e-15);
  EXPECT_NEAR(read.value->runs[0].deviation[4], 4 * um, 1e-15);
}

TEST(BallbarFile, BareTableTakesDefaults) {
  BallbarDefaults defaults{TestPlane{1, 2}, 150.0, 10.0, std::nullopt};
  const auto read = read_ballbar(
      "a.csv",
      "angle_deg;radius_mm\r\n0;150.001\r\n" +
          [] {
            std::string rows;
            for (int i = 1; i < 20; ++i) rows += std::to_string(-i * 5) + ";150\r\n";
            return rows;
          }(),
      defaults);
  ASSERT_TRUE(read.value) << codes(read);
  EXPECT_EQ(read.value->runs[0].direction, -1);
  EXPECT_NEAR(read.value->runs[0].deviation[0], 1 * um, 1e-12);
  EXPECT_THAT(codes(read_ballbar("a.csv", kHeader + table(0, 10, 37))), HasSubstr("does not say the plane"));
}

TEST(BallbarFile, AnglesWrapAndDirectionsSplitRuns) {
  std::string text = kKeys + "run,direction,angle_deg,deviation_um\n";
  for (int i = 0; i < 40; ++i) text += "1,CCW," + std::to_string((350 + i * 10) % 360) + ",1\n";
  for (int i = 0; i < 40; ++i) text += "1,CW," + std::to_string((10 - i * 10 + 720) % 360) + ",2\n";
  const auto read = read_ballbar("a.csv", text);
  ASSERT_TRUE(read.value) << codes(read);
  ASSERT_EQ(read.value->runs.size(), 2U);
  EXPECT_NEAR(read.value->runs[0].angle.back(), (350 + 390) * deg, 1e-12);
  EXPECT_EQ(read.value->runs[1].direction, -1);
  EXPECT_NEAR(travel_of(read.value->runs[1]), 390 * deg, 1e-12);
}

TEST(BallbarFile, WhatIsWrittenReadsBack) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> some(-1, 1);
  BallbarTest test;
  test.plane = {2, 0};
  test.radius = 100.0003;
  test.feed = 17.3;
  test.centre = {1.5, -2.25, 300};
  test.noise = 0.1 * um;
  test.machine = "mill 7";
  for (const int s : {+1, -1}) {
    BallbarRun run;
    run.direction = s;
    for (int i = 0; i < 50; ++i) {
      run.angle.push_back(s * (0.1 * i + 0.01 * some(random)));
      run.deviation.push_back(0.01 * some(random));
      run.time.push_back(0.01 * i);
      run.actual.push_back(test.centre + test.radius * radial_direction(test.plane, run.angle.back()));
      run.commanded.push_back(run.actual.back() + Vec3(1e-3, 0, 1e-3));
    }
    test.runs.push_back(run);
  }
  const auto read = read_ballbar("a.csv", write_ballbar(test));
  ASSERT_TRUE(read.value) << codes(read);
  EXPECT_TRUE(read.diagnostics.empty()) << codes(read);
  EXPECT_EQ(read.value->plane, test.plane);
  EXPECT_EQ(read.value->radius, test.radius);
  EXPECT_NEAR(read.value->feed, test.feed, 1e-14);
  EXPECT_EQ(read.value->centre, test.centre);
  EXPECT_EQ(read.value->machine, "mill 7");
  ASSERT_EQ(read.value->runs.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(read.value->runs[k].direction, test.runs[k].direction);
    EXPECT_EQ(read.value->runs[k].time, test.runs[k].time);
    EXPECT_EQ(read.value->runs[k].actual, test.runs[k].actual);
    EXPECT_EQ(read.value->runs[k].commanded, test.runs[k].commanded);
    for (std::size_t i = 0; i < 50; ++i) {
      EXPECT_NEAR(read.value->runs[k].angle[i], test.runs[k].angle[i], 1e-14);
      EXPECT_NEAR(read.value->runs[k].deviation[i], test.runs[k].deviation[i], 1e-16);
    }
  }
}

TEST(BallbarFile, MistakesAreNamed) {
  const auto found = [](const std::string& text) { return codes(read_ballbar("a.csv", text)); };
  EXPECT_THAT(found(""), HasSubstr("E-BALLBAR"));
  EXPECT_THAT(found(kKeys + "1,2\n3,4\n"), HasSubstr("E-CSV no header row"));
  EXPECT_THAT(found(kKeys + "angle_deg\n0\n"), HasSubstr("E-COLUMN no column deviation_um"));
  EXPECT_THAT(found(kKeys + "angle_deg,deviation_um,radius_mm\n0,1,2\n"), HasSubstr("more than one"));
  EXPECT_THAT(found(kKeys + "angle_deg,deviation_um,x_mm\n"), HasSubstr("only 1 of the columns"));
  EXPECT_THAT(found(kKeys + kHeader + "0,nan\n"), HasSubstr("E-CELL"));
  EXPECT_THAT(found(kKeys + kHeader + "0,\n"), HasSubstr("an empty cell"));
  EXPECT_THAT(found(kKeys + kHeader + "0,1,2\n"), HasSubstr("3 cells, but 2 columns"));
  EXPECT_THAT(found(kKeys + kHeader + table(0, 10, 5)), HasSubstr("E-SAMPLES run 1: 5 samples"));
  EXPECT_THAT(found(kKeys + kHeader + table(0, 60, 20)), HasSubstr("E-ANGLE run 1: the angle jumps"));
  EXPECT_THAT(found(kKeys + kHeader + table(5, 0, 20)), HasSubstr("covers 0.0 deg"));
  EXPECT_THAT(found(kKeys + kHeader + table(0, 10, 20) + table(190, -10, 20)), HasSubstr("to and fro"));
  EXPECT_THAT(found(kKeys + "angle_deg,deviation_mm\n" + table(0, 10, 37)), HasSubstr("E-RADIUS"));
  EXPECT_THAT(found("# plane: XX\n" + kHeader), HasSubstr("plane is 'XX'"));
  EXPECT_THAT(found("# radius_mm: -4\n" + kHeader), HasSubstr("radius_mm is '-4'"));
  EXPECT_THAT(found(kKeys + "angle_deg,deviation_um,time_s\n" + table(0, 10, 37, ",1")), HasSubstr("E-TIME"));
  EXPECT_THAT(found(kKeys + "direction,angle_deg,deviation_um\nleft,0,0\n"), HasSubstr("neither CCW nor CW"));
  std::string constant = kKeys + kHeader;
  for (int i = 0; i < 37; ++i) constant += std::to_string(i * 10) + ",3\n";
  EXPECT_THAT(found(constant), HasSubstr("W-BALLBAR"));
}

/// Radius 100 mm, every 5 degrees.
BallbarTest of_sixty_samples() {
  BallbarTest test;
  test.radius = 100;
  test.feed = 20;
  BallbarRun run;
  for (int i = 0; i < 60; ++i) {
    run.angle.push_back(i * 5 * deg);
    run.deviation.push_back(i * 1e-5);
  }
  test.runs = {run};
  return test;
}

TEST(BallbarFile, SwappedAxesAreSeenInThePositions) {
  BallbarTest test = of_sixty_samples();
  BallbarRun& run = test.runs[0];
  for (const double angle : run.angle) run.actual.push_back(100 * radial_direction({1, 0}, angle));
  const auto read = read_ballbar("a.csv", write_ballbar(test));
  EXPECT_FALSE(read.value);
  EXPECT_THAT(codes(read), HasSubstr("E-AXES"));
  EXPECT_THAT(read.diagnostics[0].fix, HasSubstr("the plane is YX"));
}

// 3 per cent more counts per mm: inside the tolerance of positions, but no command of this circle.
TEST(BallbarFile, CommandsOfAnotherRadiusAreRefused) {
  const auto found = [](double scale) {
    BallbarTest test = of_sixty_samples();
    BallbarRun& run = test.runs[0];
    for (const double angle : run.angle)
      run.commanded.push_back(scale * 100 * radial_direction({0, 1}, angle));
    return codes(read_ballbar("a.csv", write_ballbar(test)));
  };
  EXPECT_EQ(found(1.005), "");
  EXPECT_THAT(found(1.03),
              HasSubstr("E-RADIUS run 1: the positions x_cmd_mm y_cmd_mm z_cmd_mm are up to 3.000 mm"));
  EXPECT_THAT(found(0.97), HasSubstr("E-RADIUS"));
}

TEST(BallbarFile, ContradictionsAreTold) {
  const std::string rows = kHeader + table(0, 10, 37);
  EXPECT_THAT(codes(read_ballbar("a.csv", kKeys + "# Radius_mm: 150\n" + rows)),
              HasSubstr("E-BALLBAR a second line 'radius_mm'"));
  EXPECT_EQ(codes(read_ballbar("a.csv", kKeys + "# note: a\n# note: b\n" + rows)), "");
  const auto warned = [&](const BallbarDefaults& defaults) {
    const auto read = read_ballbar("a.csv", kKeys + rows, defaults);
    EXPECT_TRUE(read.value);
    if (read.value) {
      EXPECT_EQ(read.value->radius, 100) << "the file wins";
    }
    return codes(read);
  };
  EXPECT_EQ(warned({TestPlane{0, 1}, 100.0, 1200 / 60.0, std::nullopt}), "");
  EXPECT_THAT(warned({{}, 150.0, {}, {}}), HasSubstr("W-BALLBAR the file says another nominal radius"));
  EXPECT_THAT(warned({{}, {}, 10.0, {}}), HasSubstr("another feed"));
  EXPECT_THAT(warned({TestPlane{1, 0}, {}, {}, {}}), HasSubstr("another plane"));
}

TEST(BallbarFile, TimeContradictsTheDirection) {
  std::string text = kKeys + "direction,angle_deg,deviation_um,time_s\n";
  for (int i = 0; i < 40; ++i)
    text += "CW," + std::to_string(i * 9) + "," + std::to_string(i) + "," + std::to_string(i) + "\n";
  EXPECT_THAT(codes(read_ballbar("a.csv", text)), HasSubstr("the direction is CW, but the angle grows"));
}

TEST(BallbarFile, AnyBytesGiveAValueOrReasons) {
  std::mt19937 random(11);
  const std::string valid = kKeys + "run,direction,angle_deg,deviation_um,time_s\n" + [] {
    std::string rows;
    for (int i = 0; i < 40; ++i)
      rows += "1,CCW," + std::to_string(i * 9) + ".5,-0.25," + std::to_string(i) + "\n";
    return rows;
  }();
  constexpr std::string_view kBytes = "#,;:\n\r\t 019.eE+-nanCW\xEF\xBB\xBF\x00\xFF";
  for (int round = 0; round < 4000; ++round) {
    std::string text = valid;
    const int changes = 1 + static_cast<int>(random() % 6);
    for (int k = 0; k < changes && !text.empty(); ++k) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[at] = kBytes[random() % kBytes.size()];
          break;
        case 1:
          text.erase(at, random() % 40);
          break;
        case 2:
          text.insert(at, text.substr(random() % text.size(), random() % 40));
          break;
        default:
          text.insert(at, 1, static_cast<char>(random()));
          break;
      }
    }
    const auto read = read_ballbar("a.csv", text);
    ASSERT_EQ(read.value.has_value(), !has_errors(read.diagnostics)) << text;
    if (!read.value) continue;
    ASSERT_FALSE(read.value->runs.empty());
    for (const BallbarRun& run : read.value->runs)
      for (std::size_t i = 0; i < run.angle.size(); ++i)
        ASSERT_TRUE(std::isfinite(run.angle[i]) && std::isfinite(run.deviation[i]));
  }
}

}  // namespace
}  // namespace abbe
