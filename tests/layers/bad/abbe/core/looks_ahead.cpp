#include "abbe/chain/plan.h"
#include <openssl/evp.h>
#include <fmt/core.h>
