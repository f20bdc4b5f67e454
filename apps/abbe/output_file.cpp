#include "output_file.h"

#include <fmt/core.h>

#include <utility>
#include <variant>

#include "abbe/core/file.h"

namespace abbe::app {

bool is_apart(std::string_view option, const std::string& path, const std::vector<std::string>& inputs,
              Session& session) {
  if (path == "-") {
    session.report(option_error(option, "standard output is taken by the report", "name a file"));
    return false;
  }
  for (const std::string& input : inputs) {
    if (!same_file(path, input)) continue;
    session.report(option_error(option, fmt::format("'{}' is an input", path), "name another file"));
    return false;
  }
  return true;
}

bool publish_text(const std::string& path, std::string_view text, Session& session) {
  FileResult<SpoolFile> created = SpoolFile::create(path);
  if (const auto* error = std::get_if<FileError>(&created)) {
    session.report(*error, path);
    return false;
  }
  auto file = std::move(std::get<SpoolFile>(created));
  if (file.write(text) && !interrupted() && file.publish()) return true;
  if (!interrupted()) session.report(file.error().value_or(FileError{"cannot be written"}), path);
  return false;
}

}  // namespace abbe::app
