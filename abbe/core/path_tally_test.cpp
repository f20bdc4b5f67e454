#include "abbe/core/path_tally.h"

#include <gtest/gtest.h>

namespace abbe {
namespace {

TEST(DeviationTally, OfEquallyBadPlacesTheFirstIsNamed) {
  DeviationTally tally;
  tally.add(Vec3(0, 3e-3, 4e-3), 1, 11);
  tally.add(Vec3(0, 3e-3, 4e-3 * (1 + 1e-13)), 1, 14);
  tally.add(Vec3(1e-3, 0, 0), 2, 20);
  EXPECT_EQ(tally.summary().max_line, 11U);
  EXPECT_NEAR(tally.summary().max, 5e-3, 1e-12);
  EXPECT_NEAR(tally.summary().rms, 3.605551275463989e-3, 1e-12);  // sqrt((25 + 25 + 2) / 4) um
  tally.add(Vec3(0, 0, -5.001e-3), 1, 30);
  EXPECT_EQ(tally.summary().max_line, 30U);
}

TEST(DeviationTally, PlacesThatCreepUpAreFollowed) {
  DeviationTally tally;
  double size = 1e-3;
  for (std::uint64_t line = 1; line <= 1000; ++line, size *= 1 + 1e-10) tally.add(Vec3(size, 0, 0), 1, line);
  EXPECT_GT(tally.summary().max_line, 980U);
}

TEST(DeviationTally, APathWithoutLengthHasNoRms) {
  DeviationTally tally;
  EXPECT_EQ(tally.summary().rms, 0);
  tally.add(Vec3(-1e-3, 0, 0), 0, 7);
  EXPECT_EQ(tally.summary().rms, 0);
  EXPECT_EQ(tally.summary().max_component[0], 1e-3);
}

TEST(SampleKeeper, KeepsEveryNth) {
  SampleKeeper keeper(4);
  for (std::uint64_t line = 0; line < 1000; ++line) {
    if (!keeper.wants_next()) {
      keeper.skip();
      continue;
    }
    PathSample sample;
    sample.line = line;
    keeper.add(sample);
  }
  const std::vector<PathSample> kept = keeper.take();
  ASSERT_GE(kept.size(), 2U);
  ASSERT_LE(kept.size(), 4U);
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i].line, i * kept[1].line);
  EXPECT_GE(kept.back().line + kept[1].line, 1000U) << "up to the end";
  EXPECT_FALSE(SampleKeeper(0).wants_next());
}

TEST(NoteDatum, EachOnceAndNotWithoutEnd) {
  std::vector<DatumShift> datums;
  for (int i = 0; i < 3; ++i) note_datum(datums, {"G54", 1, Vec3(1e-3, 0, 0)});
  EXPECT_EQ(datums.size(), 1U);
  note_datum(datums, {"G54", 1, Vec3(2e-3, 0, 0)});
  note_datum(datums, {"G55", 1, Vec3(1e-3, 0, 0)});
  EXPECT_EQ(datums.size(), 3U);
  for (int tool = 0; tool < 2000; ++tool) note_datum(datums, {"G54", tool, Vec3::Zero()});
  EXPECT_EQ(datums.size(), kMostDatums);
}

}  // namespace
}  // namespace abbe
