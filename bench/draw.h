#pragma once

#include <cstdint>

namespace abbe::bench {

/// Numbers in [0, 1), the same everywhere: a linear congruence (Knuth's MMIX constants).
class Draw {
 public:
  double operator()() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_ = 1;
};

}  // namespace abbe::bench
