#pragma once

#include <vector>

#include "abbe/core/linear_algebra.h"

namespace abbe {

/// A place along a straight move: parameter 0..1 and the correction there.
struct MoveSample {
  double s = 0;
  Vec3 correction = Vec3::Zero();
};

/// The fewest pieces of a straight move such that between their ends the correction differs from the
/// straight line by at most `tolerance` (mm) at every sample. `samples` are in order, from s = 0 to s = 1.
/// Gives the indices of the samples where a piece ends; the last one is samples.size() - 1.
[[nodiscard]] std::vector<std::size_t> split_move(const std::vector<MoveSample>& samples, double tolerance);

/// Leaves out ends of pieces until no piece spans less than `least` of the move (0..1): a piece that is too
/// short is joined with the next one, the last with the one before it.
[[nodiscard]] std::vector<std::size_t> join_short(const std::vector<MoveSample>& samples,
                                                  const std::vector<std::size_t>& ends, double least);

/// How far the correction is from the straight lines between the ends of these pieces, at the samples, mm.
[[nodiscard]] double farthest_off(const std::vector<MoveSample>& samples,
                                  const std::vector<std::size_t>& ends);

}  // namespace abbe
