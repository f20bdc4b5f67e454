#pragma once
#include <fmt/core.h>

#include <vector>

#include "abbe/core/other.h"
