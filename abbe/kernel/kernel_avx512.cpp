#include "abbe/kernel/kernels.h"

#define ABBE_KERNEL_NAME "avx512"
#define ABBE_KERNEL_FUNCTION avx512_kernel
#include "abbe/kernel/kernel_table.h"
