#include "output_file.h"

#include <fmt/core.h>

#include <utility>
#include <variant>

#include "abbe/core/file.h"

namespace abbe::app {

std::optional<std::string> fetch_file(const std::string& path) {
  FileResult<std::string> bytes = read_file(path);
  if (auto* found = std::get_if<std::string>(&bytes)) return std::move(*found);
  return std::nullopt;
}

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

bool publish_texts(const std::vector<OutputText>& files, Session& session) {
  std::vector<SpoolFile> spools;
  const auto complain = [&](const std::string& path, const FileError& error) {
    if (!interrupted()) session.report(error, path);
    return false;
  };
  for (const OutputText& wanted : files) {
    FileResult<SpoolFile> created = SpoolFile::create(wanted.path);
    if (const auto* error = std::get_if<FileError>(&created)) return complain(wanted.path, *error);
    SpoolFile& file = spools.emplace_back(std::move(std::get<SpoolFile>(created)));
    if (interrupted() || !file.write(wanted.text) || !file.flush())
      return complain(wanted.path, file.error().value_or(FileError{"cannot be written"}));
  }
  for (std::size_t i = 0; i < spools.size(); ++i)
    if (!spools[i].publish())
      return complain(files[i].path, spools[i].error().value_or(FileError{"cannot be written"}));
  return true;
}

bool write_outputs(const std::vector<OutputFile>& files, const std::vector<std::string>& inputs,
                   Session& session) {
  std::vector<OutputText> wanted;
  std::vector<std::string> options;
  bool apart = true;
  for (const OutputFile& file : files) {
    if (file.path.empty()) continue;
    apart = is_apart(file.option, file.path, inputs, session) && apart;
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      if (file.path != wanted[k].path && !same_file(file.path, wanted[k].path)) continue;
      session.report(
          option_error(file.option, fmt::format("the same file as {}", options[k]), "name another file"));
      apart = false;
    }
    wanted.push_back({file.path, file.text});
    options.push_back(file.option);
  }
  return apart && publish_texts(wanted, session);
}

bool publish_text(const std::string& path, std::string_view text, Session& session) {
  return publish_texts({{path, std::string(text)}}, session);
}

}  // namespace abbe::app
