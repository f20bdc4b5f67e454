#pragma once

#include <cstddef>
#include <span>

#include "abbe/signal/wavelet.h"

namespace abbe {

// The steps of wavelet.h on memory of the caller, which must not overlap. Samples must be finite.

[[nodiscard]] inline std::size_t coefficient_count(std::size_t samples, const Wavelet& wavelet) {
  return (samples + wavelet.scaling.size() - 1) / 2;
}

/// low and high have room for coefficient_count(x.size()).
void analyse(std::span<const double> x, const Wavelet& wavelet, double* low, double* high);

/// low and high hold coefficient_count(x.size()); x is filled.
void synthesise(const double* low, const double* high, const Wavelet& wavelet, std::span<double> x);

}  // namespace abbe
