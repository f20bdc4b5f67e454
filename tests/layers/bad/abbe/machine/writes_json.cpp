#include <toml++/toml.h>

#include <nlohmann/json.hpp>

#include "machine.h"
