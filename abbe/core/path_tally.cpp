#include "abbe/core/path_tally.h"

#include <algorithm>
#include <cmath>

namespace abbe {

// Of places that are equally bad the first is named, whatever the last digits of a processor say.
constexpr double kMoreThanRounding = 1 + 1e-9;

void DeviationTally::add(const Vec3& deviation, double weight, std::uint64_t line) {
  const double square = deviation.squaredNorm();
  squares_ += weight * square;
  weights_ += weight;
  largest_ = std::max(largest_, square);
  if (square > marked_ * kMoreThanRounding) {
    marked_ = square;
    worst_.max_line = line;
  }
  for (std::size_t i = 0; i < 3; ++i)
    worst_.max_component[i] =
        std::max(worst_.max_component[i], std::abs(deviation[static_cast<Eigen::Index>(i)]));
}

DeviationSummary DeviationTally::summary() const {
  DeviationSummary result = worst_;
  result.max = std::sqrt(largest_);
  result.rms = weights_ > 0 ? std::sqrt(squares_ / weights_) : 0;
  return result;
}

void SampleKeeper::add(const PathSample& sample) {
  ++seen_;
  if (kept_.size() == limit_ && limit_ > 1) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < kept_.size(); i += 2) kept_[n++] = kept_[i];
    kept_.resize(n);
    stride_ *= 2;
    if ((seen_ - 1) % stride_ != 0) return;
  }
  if (kept_.size() < limit_) kept_.push_back(sample);
}

}  // namespace abbe
