#pragma once
#include "abbe/machine/control_setup.h"
#include "abbe/machine/machine.h"
#include <unistd.h>
#include <Eigen/Core>
