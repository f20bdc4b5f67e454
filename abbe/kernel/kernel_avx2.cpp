#include "abbe/kernel/kernels.h"

#define ABBE_KERNEL_NAME "avx2"
#define ABBE_KERNEL_FUNCTION avx2_kernel
#include "abbe/kernel/kernel_table.h"
