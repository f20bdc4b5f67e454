// part_times PASSES POINTS BRUTE
//
// A wavy field of 80 x 80 mm cut by a 3 mm ball in PASSES passes of PASSES pieces, asked at POINTS x POINTS
// points: with the tree, and every BRUTE-th point by a look at all pieces. Prints seconds of processor time
// for all points (the second kind scaled up by BRUTE), their ratio, and how far the answers are apart. 317
// 100 20: 100000 tool positions, 10000 points.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <vector>

#include "abbe/part/machined_surface.h"

namespace {

constexpr double kSize = 80, kReach = 1;
const abbe::Cutter kBall{3, 3, 30};

abbe::Vec3 field(double x, double y) { return {x, y, 2 * std::sin(x / 9) * std::cos(y / 11)}; }
abbe::Vec3 normal(double x, double y) {
  return abbe::Vec3(-2.0 / 9 * std::cos(x / 9) * std::cos(y / 11),
                    2.0 / 11 * std::sin(x / 9) * std::sin(y / 11), 1)
      .normalized();
}

std::vector<abbe::SweepPiece> pieces_of(int passes) {
  std::vector<abbe::SweepPiece> pieces;
  const double step = kSize / (passes - 1);
  const auto pose = [&](int i, int j) {
    const double x = i * step, y = j * step;
    const abbe::Vec3 tip = field(x, y) + kBall.radius * (normal(x, y) - abbe::Vec3::UnitZ());
    return abbe::ToolPose{tip, abbe::Vec3::UnitZ()};
  };
  for (int j = 0; j < passes; ++j)
    for (int i = 0; i + 1 < passes; ++i) pieces.push_back({pose(i, j), pose(i + 1, j), 0});
  return pieces;
}

double seconds_since(std::clock_t begin) {
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

}  // namespace

int main(int count, char** words) {
  if (count != 4) {
    std::fprintf(stderr, "usage: part_times PASSES POINTS BRUTE\n");
    return 2;
  }
  const int passes = std::max(2, std::atoi(words[1])), points = std::max(1, std::atoi(words[2])),
            every = std::max(1, std::atoi(words[3]));
  const std::vector<abbe::SweepPiece> pieces = pieces_of(passes);
  std::clock_t begin = std::clock();
  const abbe::MachinedSurface part(kBall, pieces);
  const double building = seconds_since(begin);
  std::vector<abbe::Ray> rays;
  for (int k = 0; k < points * points; ++k) {
    const double x = kSize * (k % points + 0.5) / points, y = kSize * (k / points + 0.5) / points;
    rays.push_back({field(x, y), normal(x, y), -kReach, kReach});
  }
  std::vector<double> tree;
  begin = std::clock();
  for (const abbe::Ray& ray : rays) tree.push_back(part.deviation(ray.p, ray.n, kReach).value_or(kReach));
  const double asking = seconds_since(begin);

  double apart = 0;
  begin = std::clock();
  for (std::size_t k = 0; k < rays.size(); k += static_cast<std::size_t>(every)) {
    double best = kReach;
    for (const abbe::SweepPiece& piece : pieces)
      if (const auto entry = abbe::entry_of(kBall, piece, rays[k])) best = std::min(best, *entry);
    apart = std::max(apart, std::abs(best - tree[k]));
  }
  const double brute = seconds_since(begin) * every;
  std::printf("%zu pieces, %zu points: tree %.3f s + %.3f s, brute force %.1f s, ratio %.0f, apart %.1e mm\n",
              pieces.size(), rays.size(), building, asking, brute, brute / (building + asking), apart);
}
