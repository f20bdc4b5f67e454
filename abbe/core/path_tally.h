#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "abbe/core/verify_report.h"

namespace abbe {

/// Largest and root-mean-square deviation:
///
///   rms^2 = sum w |d|^2 / sum w,  w = path since the sample before, mm
///
/// A path without length has no rms: 0. Of places that are equally bad the first is named.
///
/// laws     OfEquallyBadPlacesTheFirstIsNamed, PlacesThatCreepUpAreFollowed, APathWithoutLengthHasNoRms
class DeviationTally {
 public:
  /// deviation: mm, workpiece axes, finite; weight: mm, not negative; line: of the original.
  void add(const Vec3& deviation, double weight, std::uint64_t line);
  [[nodiscard]] DeviationSummary summary() const;

 private:
  DeviationSummary worst_;  ///< without `max` and `rms`
  double squares_ = 0, weights_ = 0;
  double largest_ = 0, marked_ = 0;  ///< squares: of the largest deviation, of the one at max_line
};

/// At most `limit` samples, evenly spread over however many come: every n-th is kept, and when there is
/// no more room every second one goes and n doubles.
class SampleKeeper {
 public:
  explicit SampleKeeper(std::size_t limit) : limit_(limit) {}
  [[nodiscard]] bool wants_next() const { return limit_ > 0 && seen_ % stride_ == 0; }
  void skip() { ++seen_; }
  void add(const PathSample& sample);
  [[nodiscard]] std::vector<PathSample> take() { return std::move(kept_); }

 private:
  std::size_t limit_;
  std::uint64_t seen_ = 0, stride_ = 1;
  std::vector<PathSample> kept_;
};

}  // namespace abbe
