#include "output_files.h"

#include <fmt/core.h>

#include <utility>
#include <variant>

#include "abbe/core/file.h"

namespace abbe::app {
namespace {

bool same(const std::string& a, const std::string& b) { return a == b || same_file(a, b); }

bool may_be_written(const std::vector<OutputFile>& files, std::size_t i,
                    const std::vector<std::string>& inputs, Session& session) {
  const OutputFile& file = files[i];
  const auto refuse = [&](std::string message) {
    session.report(option_error(file.option, std::move(message), "name another file"));
    return false;
  };
  if (file.path == "-") return refuse("standard output is taken by the answer");
  for (const std::string& input : inputs)
    if (same(file.path, input)) return refuse(fmt::format("'{}' is an input", file.path));
  for (std::size_t k = 0; k < i; ++k)
    if (same(file.path, files[k].path)) return refuse(fmt::format("the same file as {}", files[k].option));
  return true;
}

}  // namespace

bool write_outputs(const std::vector<OutputFile>& all, const std::vector<std::string>& inputs,
                   Session& session) {
  std::vector<OutputFile> files;
  for (const OutputFile& file : all)
    if (!file.path.empty()) files.push_back(file);
  bool apart = true;
  for (std::size_t i = 0; i < files.size(); ++i) apart = may_be_written(files, i, inputs, session) && apart;
  if (!apart) return false;

  std::vector<SpoolFile> spools;
  const auto failed = [&](const SpoolFile& spool, const OutputFile& file) {
    session.report(spool.error().value_or(FileError{"cannot be written"}), file.path);
    return false;
  };
  for (const OutputFile& file : files) {
    FileResult<SpoolFile> created = SpoolFile::create(file.path);
    if (const auto* error = std::get_if<FileError>(&created)) {
      session.report(*error, file.path);
      return false;
    }
    SpoolFile& spool = spools.emplace_back(std::move(std::get<SpoolFile>(created)));
    if (!spool.write(file.text) || !spool.flush()) return failed(spool, file);
  }
  if (interrupted()) return false;
  for (std::size_t i = 0; i < files.size(); ++i)
    if (!spools[i].publish()) return failed(spools[i], files[i]);
  return true;
}

}  // namespace abbe::app
