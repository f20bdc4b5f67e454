#include "abbe/compensate/line_split.h"

namespace abbe {
namespace {

bool straight(const std::vector<MoveSample>& samples, std::size_t from, std::size_t to, double tolerance) {
  const MoveSample& a = samples[from];
  const MoveSample& b = samples[to];
  const double span = b.s - a.s;
  for (std::size_t k = from + 1; k < to; ++k) {
    const double t = span > 0 ? (samples[k].s - a.s) / span : 0;
    const Vec3 chord = a.correction + t * (b.correction - a.correction);
    if ((samples[k].correction - chord).squaredNorm() > tolerance * tolerance) return false;
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

}  // namespace abbe
