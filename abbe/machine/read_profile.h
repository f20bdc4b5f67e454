#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/machine/profile.h"

namespace abbe {

/// A profile file that is part of the program (profiles/NAME.toml).
struct EmbeddedProfile {
  std::string_view name, text;
};
[[nodiscard]] std::span<const EmbeddedProfile> embedded_profiles();
[[nodiscard]] std::vector<std::string> embedded_profile_names();

/// Reads a profile file (docs/dialects.md). With `extends = "fanuc"` it begins as that embedded profile and
/// changes what it names. All mistakes are reported, each with its place.
/// Total: any bytes give a value or diagnostics.
[[nodiscard]] Parsed<Profile> read_profile(const std::string& file, std::string_view text);

/// The embedded profile of that name; nullptr if there is none. Shared by all who ask: it never changes.
[[nodiscard]] std::shared_ptr<const Profile> embedded_profile(std::string_view name);

}  // namespace abbe
