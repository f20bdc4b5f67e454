#include "machine.h"
#include <nlohmann/json.hpp>
#include <toml++/toml.h>
