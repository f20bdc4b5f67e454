#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

namespace abbe {

/// Reference numbers of the signal functions (50-digit arithmetic and PyWavelets, from the equations of seed
/// 004), kept beside the repository; nullopt where they are not.
inline std::optional<nlohmann::json> golden_signal() {
  std::ifstream file(ABBE_SOURCE_DIR "/../shared/golden/seed004_signal.json");
  if (!file) return std::nullopt;
  return nlohmann::json::parse(file);
}

}  // namespace abbe
