#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace abbe::cli {

/// One run of the program as a user sees it.
struct ProgramRun {
  int exit = -1;  ///< exit code; 128 + signal if one ended it
  std::string out, err;
};

/// The program under test: the one of this build, or what the environment variable ABBE_PROGRAM names.
[[nodiscard]] std::string program_path();

/// Runs `abbe` with these arguments in `folder`; `input` is its standard input.
[[nodiscard]] ProgramRun run_abbe(const std::vector<std::string>& arguments, std::string_view input = {},
                                  const std::string& folder = ".");

/// Starts `abbe` and interrupts it (SIGINT) as soon as it catches that, which is before its work begins.
/// Returns its exit code; 128 + signal if that ended it.
[[nodiscard]] int interrupt_abbe(const std::vector<std::string>& arguments);

/// A folder of its own for a test, removed with this object.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string operator/(std::string_view name) const { return path_ + "/" + std::string(name); }
  /// Writes a file and returns its path.
  std::string put(std::string_view name, std::string_view text) const;

 private:
  std::string path_;
};

}  // namespace abbe::cli
