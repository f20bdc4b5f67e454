#include "abbe/program/block.h"
#include "abbe/chain/plan.h"
#include <gtest/gtest.h>
