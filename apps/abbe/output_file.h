#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "session.h"

namespace abbe::app {

/// False after reporting that `path` (of `option`) is standard output or one of the inputs.
[[nodiscard]] bool is_apart(std::string_view option, const std::string& path,
                            const std::vector<std::string>& inputs, Session& session);

/// Writes `text` to a file that appears whole or not at all; false after reporting why not.
bool publish_text(const std::string& path, std::string_view text, Session& session);

}  // namespace abbe::app
