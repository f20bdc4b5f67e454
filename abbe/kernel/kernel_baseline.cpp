#include "abbe/kernel/kernels.h"

#define ABBE_KERNEL_NAME "baseline"
#define ABBE_KERNEL_FUNCTION baseline_kernel
#include "abbe/kernel/kernel_table.h"
