#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"

namespace abbe::app {

/// Why a run ends as it does (docs/command-line.md, exit codes). The numbers are the exit codes.
enum class Exit {
  done = 0,
  internal = 1,   ///< internal error, or input and output failed
  invalid = 2,    ///< usage, missing file, machine file or data not valid
  refused = 3,    ///< a program that is not safely understood, a correction that was not found
  warnings = 4,   ///< done, with warnings, under --strict
  outside = 5,    ///< outside the calibrated volume or the travels
  disagrees = 6,  ///< the verification failed
  interrupted = 130,
};

/// Standard output with its errors noticed: a full disk must not look like success, a closed pipe
/// (`abbe ... | head`) is nobody's mistake.
class Output {
 public:
  void write(std::string_view text);
  void flush();
  [[nodiscard]] bool ok() const { return error_ == 0; }
  [[nodiscard]] bool closed_by_reader() const;
  [[nodiscard]] std::string error_text() const;

 private:
  std::string pending_;
  int error_ = 0;  ///< errno of the first failure
};

/// One run of the program: where results go, what was found, how it ends.
class Session {
 public:
  Output out;
  bool strict = false;

  /// Prints the finding on standard error. An error ends the run with `reason`.
  void report(const Diagnostic& diagnostic, Exit reason = Exit::invalid);
  void report(const Diagnostics& diagnostics, Exit reason = Exit::invalid);
  /// A file that cannot be read or written: missing or unsuitable is the user's, the rest is I/O.
  void report(const FileError& error, const std::string& path);

  void note(Exit reason);  ///< the run ends with this code unless a more important one is noted
  [[nodiscard]] bool has(Exit reason) const;
  [[nodiscard]] std::size_t warnings() const { return warnings_; }
  /// Of all reasons noted the one that wins: 130, 1, then 2, 3, 5, 6, 4.
  [[nodiscard]] int exit_code() const;

 private:
  unsigned reasons_ = 0;  ///< bit set by position in the order above
  std::size_t warnings_ = 0;
};

/// A finding about an option of the command line.
[[nodiscard]] Diagnostic option_error(std::string_view option, std::string message, std::string fix = {});
[[nodiscard]] Diagnostic option_warning(std::string_view option, std::string message, std::string fix = {});

/// From now on SIGINT and SIGTERM ask the run to stop (a second one kills it) and standard input can no
/// longer be read, so that waiting for it ends with an error; SIGPIPE and SIGXFSZ are errors of write().
/// There is one such flag per process because there is one signal handler.
void catch_signals();
[[nodiscard]] bool interrupted();

}  // namespace abbe::app
