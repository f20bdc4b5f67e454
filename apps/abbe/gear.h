#pragma once

#include <optional>
#include <string>

#include "abbe/gear/gear_file.h"
#include "verbs.h"

namespace abbe::app {

// The kinds of `abbe gear`.
[[nodiscard]] Verb gear_make_verb(Command& gear, Session& session);
[[nodiscard]] Verb gear_cut_verb(Command& gear, Session& session);
[[nodiscard]] Verb gear_sensitivity_verb(Command& gear, Session& session);
[[nodiscard]] Verb gear_correct_verb(Command& gear, Session& session);

/// A gear file and the wheel in its gap.
struct LoadedGear {
  GearJob job;
  WheelInGap wheel;
};

/// Reads the gear file; nullopt after reporting all mistakes.
[[nodiscard]] std::optional<LoadedGear> load_gear(const std::string& path, Session& session);

}  // namespace abbe::app
