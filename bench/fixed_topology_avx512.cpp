#define ABBE_FIXED_FUNCTION correct_fixed_avx512
#include "bench/fixed_topology_code.h"
