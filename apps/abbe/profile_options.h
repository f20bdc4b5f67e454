#pragma once

#include <memory>
#include <string>

#include "abbe/machine/profile.h"
#include "command_line.h"
#include "session.h"

namespace abbe::app {

/// Options that say for which control a program is, as typed.
struct ProfileArguments {
  std::string dialect, file;         ///< an embedded profile, or a file
  std::string integer_words, units;  ///< what the program and the profile leave open; empty: not given
};

void add_profile_options(Command& verb, ProfileArguments& arguments);

/// The profile, with what the options add; nullptr after reporting all mistakes.
[[nodiscard]] std::shared_ptr<const Profile> load_profile(const ProfileArguments& arguments,
                                                          Session& session);

}  // namespace abbe::app
