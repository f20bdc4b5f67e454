#define ABBE_FIXED_FUNCTION correct_fixed_avx2
#include "bench/fixed_topology_code.h"
