#include "abbe/kernel/kernel.h"

#include "abbe/kernel/kernels.h"

namespace abbe::kernel {
namespace {

[[nodiscard]] bool has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

[[nodiscard]] bool has_avx512() {
#if defined(__x86_64__)
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
#else
  return false;
#endif
}

}  // namespace

bool corrects(const FlatView& view, std::uint32_t free) {
  int linear = 0, rotary = 0;
  for (int i = 0; i < view.axis_count; ++i) {
    if ((free >> i & 1) != 0) ++((view.rotary >> i & 1) != 0 ? rotary : linear);
  }
  return linear == 3 && rotary <= 2;
}

const Kernel* named(std::string_view name) {
  if (name == "baseline") return &baseline_kernel();
#if defined(__x86_64__)
  if (name == "avx2" && has_avx2()) return &avx2_kernel();
  if (name == "avx512" && has_avx512()) return &avx512_kernel();
#endif
  return nullptr;
}

const Kernel& best() {
#if defined(__x86_64__)
  if (has_avx512()) return avx512_kernel();
  if (has_avx2()) return avx2_kernel();
#endif
  return baseline_kernel();
}

}  // namespace abbe::kernel
