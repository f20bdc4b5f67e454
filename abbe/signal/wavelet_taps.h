#pragma once

#include <array>
#include <span>

namespace abbe::wavelet_taps {

/// Scaling filters by the number p of vanishing moments, p = 1 first; empty where the family begins later.
inline constexpr int kMostMoments = 20;
using Family = std::array<std::span<const double>, kMostMoments>;
extern const Family kDaubechies;
extern const Family kSymlets;

}  // namespace abbe::wavelet_taps
