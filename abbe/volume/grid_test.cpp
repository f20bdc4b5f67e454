#include "abbe/volume/grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace abbe {
namespace {

TEST(Grid, SpacedHasItsEndsAndItsMiddle) {
  const auto x = spaced(-250, 250, 21);
  ASSERT_TRUE(x.has_value());
  ASSERT_EQ(x->size(), 21U);
  EXPECT_EQ(x->front(), -250);
  EXPECT_EQ((*x)[10], 0);
  EXPECT_EQ((*x)[13], 75);
  EXPECT_EQ(x->back(), 250);
  EXPECT_EQ(*spaced(0.1, 0.3, 2), (std::vector<double>{0.1, 0.3}));
  EXPECT_EQ(*spaced(10, 20, 1), std::vector<double>{15});
  EXPECT_EQ(*spaced(10, 10, 1), std::vector<double>{10});
}

TEST(Grid, SpacedRefusesWhatIsNoInterval) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(spaced(1, 1, 2));
  EXPECT_FALSE(spaced(2, 1, 5));
  EXPECT_FALSE(spaced(2, 1, 1));
  EXPECT_FALSE(spaced(0, 1, 0));
  EXPECT_FALSE(spaced(0, infinity, 3));
  EXPECT_FALSE(spaced(std::nan(""), 1, 3));
  EXPECT_FALSE(spaced(-1.7e308, 1.7e308, 3));
}

TEST(Grid, EveryCombinationOnceTheLastAxisFastest) {
  const VolumeGrid grid{{{1, 2}, {5}, {10, 20, 30}}};
  ASSERT_EQ(grid.size(), 6U);
  EXPECT_TRUE(grid.varies(0));
  EXPECT_FALSE(grid.varies(1));
  EXPECT_EQ(grid.at(0)[0], 1);
  EXPECT_EQ(grid.at(1)[2], 20);
  EXPECT_EQ(grid.at(3)[0], 2);
  EXPECT_EQ(grid.at(3)[2], 10);
  std::set<std::array<double, kMaxAxes>> seen;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    EXPECT_EQ(grid.at(i)[1], 5);
    seen.insert(grid.at(i));
  }
  EXPECT_EQ(seen.size(), 6U);
}

TEST(Grid, SizeThatCannotBeCountedIsZero) {
  const std::vector<double> many(std::size_t{1} << 16);
  EXPECT_EQ((VolumeGrid{{many, many, many}}.size()), std::size_t{1} << 48);
  EXPECT_EQ((VolumeGrid{{many, many, many, many, many}}.size()), 0U);
  EXPECT_EQ((VolumeGrid{{{1, 2}, {}}}.size()), 0U);
  EXPECT_EQ(VolumeGrid{}.size(), 0U);
}

TEST(Grid, DefaultCountsAreOddAndStaySmall) {
  for (std::size_t axes = 1; axes <= 8; ++axes) {
    const std::size_t count = default_count(axes);
    EXPECT_EQ(count % 2, 1U);
    EXPECT_LT(std::pow(static_cast<double>(count), static_cast<double>(axes)), 20000) << axes;
  }
  EXPECT_EQ(default_count(3), 21U);
}

TEST(Grid, DefaultDatumIsTheZeroOrTheNearestEnd) {
  const auto q = default_datum(VolumeGrid{{{-10, 10}, {5, 7}, {-7, -5}, {3}}});
  EXPECT_EQ(q[0], 0);
  EXPECT_EQ(q[1], 5);
  EXPECT_EQ(q[2], -5);
  EXPECT_EQ(q[3], 3);
}

}  // namespace
}  // namespace abbe
