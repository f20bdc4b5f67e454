#include "abbe/part/tool_way.h"

#include <gtest/gtest.h>

#include <cmath>

namespace abbe {
namespace {

const PartBox kEverywhere{Vec3(-1e3, -1e3, -1e3), Vec3(1e3, 1e3, 1e3)};

MotionPoses line(const Vec3& from, const Vec3& to, bool rapid = false, bool connected = true) {
  MotionPoses out;
  out.rapid = rapid;
  out.connected = connected;
  out.length = (to - from).norm();
  out.share = {0, 0.5, 1};
  for (const double s : out.share) out.poses.push_back({from + s * (to - from), Vec3::UnitZ()});
  return out;
}

std::vector<SweepPiece> way(const Disturbance& disturbance) {
  ToolWay out(Cutter{3, 3, 30}, disturbance, kEverywhere);
  out.add(line({0, 0, 5}, {0, 0, 0}, true, false));
  for (int k = 0; k < 200; ++k) out.add(line(Vec3(k, 0, 0), Vec3(k + 1, 0, 0)));
  return out.take();
}

TEST(ToolWay, WithoutDisturbanceThePosesAreThePieces) {
  const std::vector<SweepPiece> pieces = way({});
  ASSERT_EQ(pieces.size(), 402u);
  EXPECT_EQ(pieces[2].from.tip, Vec3(0, 0, 0));
  EXPECT_EQ(pieces[2].to.tip, Vec3(0.5, 0, 0));
  EXPECT_EQ(pieces.back().worn, 0);
}

TEST(ToolWay, WearIsOfTheFeedLength) {
  Disturbance worn;
  worn.wear = 1e-5;
  worn.worn = 0.002;
  const std::vector<SweepPiece> pieces = way(worn);
  EXPECT_DOUBLE_EQ(pieces[0].worn, 0.002) << "rapids wear nothing";
  EXPECT_NEAR(pieces.back().worn, 0.002 + 1e-5 * 199.75, 1e-15);
}

TEST(ToolWay, SameSeedSameWay) {
  Disturbance noisy;
  noisy.noise = 0.003;
  const std::vector<SweepPiece> a = way(noisy), b = way(noisy);
  noisy.seed = 2;
  const std::vector<SweepPiece> c = way(noisy);
  double squares = 0;
  for (std::size_t k = 2; k < a.size(); ++k) {
    EXPECT_EQ(a[k].to.tip, b[k].to.tip);
    if (k > 2) {
      EXPECT_LT((a[k].from.tip - a[k - 1].to.tip).norm(), 1e-12) << "no jumps";
    }
    if (k % 2 == 1) squares += a[k].to.tip.z() * a[k].to.tip.z();
  }
  EXPECT_NE(a[9].to.tip, c[9].to.tip);
  EXPECT_NEAR(std::sqrt(squares / 200), 0.003, 0.0006);
}

TEST(ToolWay, OnlyWhatReachesTheRegionIsKept) {
  ToolWay out(Cutter{3, 3, 30}, {}, {Vec3(100, -1, -1), Vec3(110, 1, 1)});
  for (int k = 0; k < 200; ++k) out.add(line(Vec3(k, 0, 0), Vec3(k + 1, 0, 0)));
  EXPECT_NEAR(static_cast<double>(out.take().size()), 2 * (10 + 2 * 36), 3);
  EXPECT_NEAR(out.feed_length(), 200, 1e-9) << "the rest wears the cutter, too";
}

}  // namespace
}  // namespace abbe
