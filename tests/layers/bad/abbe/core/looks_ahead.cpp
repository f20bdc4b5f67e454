#include <fmt/core.h>
#include <openssl/evp.h>

#include "abbe/chain/plan.h"
