#pragma once

#include "abbe/kernel/kernel.h"

namespace abbe::kernel {

// One per instruction set that this build has.
[[nodiscard]] const Kernel& baseline_kernel();
#if defined(__x86_64__)
[[nodiscard]] const Kernel& avx2_kernel();
[[nodiscard]] const Kernel& avx512_kernel();
#endif

}  // namespace abbe::kernel
