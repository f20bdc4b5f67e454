// denoise_times SAMPLES ROUNDS
//
// Denoises a noisy sine of SAMPLES samples with sym5 on 5 levels, soft, and prints the processor time of the
// best round in seconds. bench/compare_pywavelets.py holds PyWavelets beside it.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <variant>

#include "abbe/signal/denoise.h"

int main(int count, char** words) {
  if (count != 3) {
    std::fprintf(stderr, "usage: denoise_times SAMPLES ROUNDS\n");
    return 2;
  }
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  abbe::Samples y(std::strtoul(words[1], nullptr, 10));
  for (std::size_t i = 0; i < y.size(); ++i)
    y[i] = 10 * std::sin(1e-3 * static_cast<double>(i)) + noise(random);
  const abbe::Wavelet sym5 = *abbe::find_wavelet("sym5");
  abbe::DenoiseOptions options;
  options.threshold = abbe::DenoiseOptions::Threshold::soft;
  double best = 1e9, sum = 0;
  for (int round = 0; round < std::atoi(words[2]); ++round) {
    const std::clock_t begin = std::clock();
    const auto result = abbe::denoise(y, sym5, options);
    best = std::min(best, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    if (const auto* denoised = std::get_if<abbe::Denoised>(&result)) sum += denoised->samples[y.size() / 2];
  }
  std::printf("%.6f (%.3g)\n", best, sum);
}
