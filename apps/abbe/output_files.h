#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "session.h"

namespace abbe::app {

/// A file that a verb writes beside its answer.
struct OutputFile {
  std::string option;  ///< that named it: "--svg"
  std::string path;    ///< empty: not asked for
  std::string text;
};

/// Writes all of them whole, none before every one is complete. Refuses (before anything is written) a path
/// that is an input, another output, or "-" where standard output is taken by the answer.
[[nodiscard]] bool write_outputs(const std::vector<OutputFile>& files, const std::vector<std::string>& inputs,
                                 Session& session);

}  // namespace abbe::app
