#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "abbe/core/progress.h"

namespace abbe::app {

/// A progress bar on standard error: only on a terminal, only after half a second, one line that
/// goes away at the end. Colour unless NO_COLOR is set.
class ProgressBar {
 public:
  /// `what` leads the line ("verify part.ngc"); not `wanted`: nothing is ever shown. `millions` is what a
  /// million of the things counted is called.
  ProgressBar(std::string what, bool wanted = true, std::string millions = "MB");
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Bytes (or poses ..) done of a total (0 = unknown).
  void show(std::uint64_t done, std::uint64_t total);

  /// The same for the library's long work; it also stops the work when the user interrupts.
  [[nodiscard]] Progress callback();

 private:
  using Clock = std::chrono::steady_clock;
  std::string what_, millions_;
  bool active_ = false, colour_ = false, drawn_ = false;
  Clock::time_point start_, last_;
};

}  // namespace abbe::app
