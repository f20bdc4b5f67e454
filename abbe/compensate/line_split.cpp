#include "abbe/compensate/line_split.h"

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

/// Of the samples between two of them: squared distance from the straight line between these.
double squared_bend(const std::vector<MoveSample>& samples, std::size_t from, std::size_t to, std::size_t k) {
  const MoveSample& a = samples[from];
  const MoveSample& b = samples[to];
  const double span = b.s - a.s;
  const double t = span > 0 ? (samples[k].s - a.s) / span : 0;
  const Vec3 chord = a.correction + t * (b.correction - a.correction);
  return (samples[k].correction - chord).squaredNorm();
}

bool straight(const std::vector<MoveSample>& samples, std::size_t from, std::size_t to, double tolerance) {
  for (std::size_t k = from + 1; k < to; ++k) {
    if (squared_bend(samples, from, to, k) > tolerance * tolerance) return false;
  }
  return true;
}

}  // namespace

std::vector<std::size_t> split_move(const std::vector<MoveSample>& samples, double tolerance) {
  std::vector<std::size_t> ends;
  const std::size_t last = samples.size() - 1;
  std::size_t from = 0;
  while (from < last) {
    if (straight(samples, from, last, tolerance)) {
      ends.push_back(last);
      break;
    }
    // Grow by doubling, then close in: a longer piece that holds is not missed by more than one sample.
    std::size_t good = from + 1, step = 1;
    while (good + step < last && straight(samples, from, good + step, tolerance)) {
      good += step;
      step *= 2;
    }
    for (; step >= 1; step /= 2) {
      while (good + step < last && straight(samples, from, good + step, tolerance)) good += step;
      if (step == 1) break;
    }
    ends.push_back(good);
    from = good;
  }
  return ends;
}

std::vector<std::size_t> join_short(const std::vector<MoveSample>& samples,
                                    const std::vector<std::size_t>& ends, double least) {
  constexpr double kRounding = 1e-9;
  std::vector<std::size_t> kept;
  double from = 0;
  for (const std::size_t end : ends) {
    if (samples[end].s - from < least - kRounding) continue;
    kept.push_back(end);
    from = samples[end].s;
  }
  if (kept.empty()) return {ends.back()};
  kept.back() = ends.back();  // what is left is too short for a piece of its own
  return kept;
}

double farthest_off(const std::vector<MoveSample>& samples, const std::vector<std::size_t>& ends) {
  double farthest = 0;
  std::size_t from = 0;
  for (const std::size_t to : ends) {
    for (std::size_t k = from + 1; k < to; ++k)
      farthest = std::max(farthest, squared_bend(samples, from, to, k));
    from = to;
  }
  return std::sqrt(farthest);
}

}  // namespace abbe
