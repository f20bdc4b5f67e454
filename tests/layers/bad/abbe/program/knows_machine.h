#pragma once
#include <unistd.h>

#include <Eigen/Core>

#include "abbe/machine/control_setup.h"
#include "abbe/machine/machine.h"
