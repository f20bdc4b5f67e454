#include "abbe/verify/tally.h"

#include <gtest/gtest.h>

namespace abbe::verifying {
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

}  // namespace
}  // namespace abbe::verifying
