#include <gtest/gtest.h>

#include "abbe/chain/plan.h"
#include "abbe/program/block.h"
