#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "session.h"

namespace abbe::app {

/// False after reporting that `path` (of `option`) is standard output or one of the inputs.
[[nodiscard]] bool is_apart(std::string_view option, const std::string& path,
                            const std::vector<std::string>& inputs, Session& session);

/// Fetches files of the disk for readers that name others.
[[nodiscard]] std::optional<std::string> fetch_file(const std::string& path);

/// A text and the path it is for.
struct OutputText {
  std::string path, text;
};

/// Writes all files or none: each is complete before the first of them appears.
bool publish_texts(const std::vector<OutputText>& files, Session& session);

/// A file that a verb writes beside its answer.
struct OutputFile {
  std::string option;  ///< that named it: "--svg"
  std::string path;    ///< empty: not asked for
  std::string text;
};

/// Writes all that are asked for, or none. Refuses (before anything is written) a path that is an input,
/// another output, or standard output.
[[nodiscard]] bool write_outputs(const std::vector<OutputFile>& files, const std::vector<std::string>& inputs,
                                 Session& session);

/// Writes `text` to a file that appears whole or not at all; false after reporting why not.
bool publish_text(const std::string& path, std::string_view text, Session& session);

}  // namespace abbe::app
