#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "abbe/capture/write_capture.h"

namespace abbe {

/// A file of this test alone, removed with the object.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& name)
      : path_((std::filesystem::temp_directory_path() / ("abbe_" + std::to_string(::getpid()) + "_" + name))
                  .string()) {}
  ~ScratchFile() { std::remove(path_.c_str()); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

  [[nodiscard]] std::vector<std::uint8_t> bytes() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void put(const std::vector<std::uint8_t>& bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }

 private:
  std::string path_;
};

/// X and Y of a machine that does not exist: 10000 counts/mm on X, -3600 counts/deg on the turning Y.
inline std::vector<ServoAxis> two_axes() { return {{"X", 1001, 10000, "mm"}, {"Y", 1002, -3600, "deg"}}; }

/// Writes a synthetic capture; what was wrong, or nothing.
inline std::optional<Diagnostic> put_capture(const std::string& path, const ProcessMap& map,
                                             const std::vector<CaptureColumn>& columns,
                                             const CaptureSettings& settings = {}) {
  auto created = SpoolFile::create(path);
  auto& out = std::get<SpoolFile>(created);
  auto misfit = write_capture(map, columns, settings, out);
  if (!misfit && !out.publish()) misfit = Diagnostic{};
  return misfit;
}

}  // namespace abbe
