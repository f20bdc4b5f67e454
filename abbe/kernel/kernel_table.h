// The last lines of every kernel_*.cpp: its table of functions. No #pragma once: one inclusion per file.

#include "abbe/kernel/kernel_code.h"

namespace abbe::kernel {
namespace {

void tips(const FlatView& plan, const Setting& setting, const double* const* q, std::size_t count,
          double* const* tip, unsigned char* lanes) {
  if (count == 1) return tips_of<double>(plan, setting, {q, 0, 1}, tip, lanes);
  if (count == 2) return tips_of<Pair>(plan, setting, {q, 0, 2}, tip, lanes);
  for (std::size_t i = 0; i < count; i += kNativeLanes)
    tips_of<Native>(plan, setting, {q, i, count}, tip, lanes);
}

}  // namespace

const Kernel& ABBE_KERNEL_FUNCTION() {
  static constexpr Kernel kernel = {ABBE_KERNEL_NAME, static_cast<int>(kNativeLanes), tips, nullptr};
  return kernel;
}

}  // namespace abbe::kernel
