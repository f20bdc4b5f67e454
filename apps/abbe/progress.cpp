#include "progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "session.h"

namespace abbe::app {
namespace {

constexpr std::chrono::milliseconds kFirst{500}, kBetween{100};
constexpr int kBarWidth = 24;
constexpr double kMillion = 1e6;

}  // namespace

ProgressBar::ProgressBar(std::string what, bool wanted, std::string millions)
    : what_(std::move(what)), millions_(std::move(millions)), start_(Clock::now()), last_(start_) {
  const char* no_colour = std::getenv("NO_COLOR");
  colour_ = no_colour == nullptr || *no_colour == '\0';
  active_ = wanted && ::isatty(STDERR_FILENO) == 1;
}

ProgressBar::~ProgressBar() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void ProgressBar::show(std::uint64_t done, std::uint64_t total) {
  if (!active_) return;
  const Clock::time_point now = Clock::now();
  if (now - start_ < kFirst || (drawn_ && now - last_ < kBetween)) return;
  last_ = now;
  drawn_ = true;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double done_millions = static_cast<double>(done) / kMillion;
  const double rate = done_millions / seconds;
  if (total == 0) {
    fmt::print(stderr, "\r\033[K{}  {:.1f} {}  {:.1f} {}/s", what_, done_millions, millions_, rate,
               millions_);
  } else {
    const double part = std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
    const int full = static_cast<int>(part * kBarWidth);
    const double left = part > 0 ? seconds * (1 - part) / part : 0;
    const std::string bar = std::string(static_cast<std::size_t>(full), '#') +
                            std::string(static_cast<std::size_t>(kBarWidth - full), '.');
    fmt::print(stderr, "\r\033[K{}  {:3.0f}% {}{}{}  {:.1f}/{:.1f} {}  {:.1f} {}/s  ETA {:.0f} s", what_,
               100 * part, colour_ ? "\033[32m" : "", bar, colour_ ? "\033[0m" : "", done_millions,
               static_cast<double>(total) / kMillion, millions_, rate, millions_, left);
  }
  std::fflush(stderr);
}

Progress ProgressBar::callback() {
  return [this](std::uint64_t done, std::uint64_t total) {
    show(done, total);
    return !interrupted();
  };
}

}  // namespace abbe::app
