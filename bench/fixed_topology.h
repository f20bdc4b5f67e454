#pragma once

#include "abbe/kernel/kernel.h"

namespace abbe::bench {

/// Kernel::correct_poses of one instruction set, first order, for one topology that the compiler knows: the
/// table-table machine of kernel_ratios, with all numbers read from the plan. What a machine file costs is
/// its ratio to the kernel. False: the plan has other steps, `count` is no multiple of 16, or a pose is not
/// ordinary.
using FixedTopology = bool (*)(const kernel::FlatView& plan, const kernel::Setting& setting,
                               const double* const* q, std::size_t count, double* const* corrected,
                               double* last);

#if defined(__x86_64__)
bool correct_fixed_avx2(const kernel::FlatView& plan, const kernel::Setting& setting, const double* const* q,
                        std::size_t count, double* const* corrected, double* last);
bool correct_fixed_avx512(const kernel::FlatView& plan, const kernel::Setting& setting,
                          const double* const* q, std::size_t count, double* const* corrected, double* last);
#endif

}  // namespace abbe::bench
