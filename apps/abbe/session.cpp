#include "session.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <utility>

namespace abbe::app {
namespace {

constexpr std::size_t kFlushAt = std::size_t{1} << 16;

/// The order in which reasons win.
constexpr std::array kPriority = {Exit::interrupted, Exit::internal,  Exit::invalid,  Exit::refused,
                                  Exit::outside,     Exit::disagrees, Exit::warnings, Exit::done};

unsigned bit_of(Exit reason) {
  for (std::size_t i = 0; i < kPriority.size(); ++i) {
    if (kPriority[i] == reason) return 1U << i;
  }
  return 0;
}

volatile std::sig_atomic_t stop_requested = 0;

/// Reading from it fails. In the place of standard input it ends a read that waits for a pipe or a person.
int unreadable = -1;

extern "C" void request_stop(int) {
  const int before = errno;
  stop_requested = 1;
  if (unreadable >= 0) ::dup2(unreadable, STDIN_FILENO);
  errno = before;
}

Diagnostic about_option(Severity severity, std::string_view option, std::string message, std::string fix) {
  Diagnostic diagnostic;
  diagnostic.severity = severity;
  diagnostic.code = severity == Severity::error ? "E-OPTION" : "W-OPTION";
  diagnostic.place.file = std::string(option);
  diagnostic.message = std::move(message);
  diagnostic.fix = std::move(fix);
  return diagnostic;
}

}  // namespace

void Output::write(std::string_view text) {
  if (!ok()) return;
  pending_ += text;
  if (pending_.size() >= kFlushAt) flush();
}

void Output::flush() {
  std::string_view rest = pending_;
  while (ok() && !rest.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, rest.data(), rest.size());
    if (written >= 0) {
      rest.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      error_ = errno;
    }
  }
  pending_.clear();
}

bool Output::closed_by_reader() const { return error_ == EPIPE; }

std::string Output::error_text() const { return std::strerror(error_); }

void Session::report(const Diagnostic& diagnostic, Exit reason) {
  // What work says that was broken off is no finding.
  if (!interrupted()) std::fputs(to_text(diagnostic).c_str(), stderr);
  if (diagnostic.severity == Severity::error) note(reason);
  if (diagnostic.severity == Severity::warning) ++warnings_;
}

void Session::report(const Diagnostics& diagnostics, Exit reason) {
  for (const Diagnostic& diagnostic : diagnostics) report(diagnostic, reason);
}

void Session::report(const FileError& error, const std::string& path) {
  Diagnostic diagnostic;
  diagnostic.code = "E-FILE";
  diagnostic.place.file = path;
  // The path leads every finding already.
  const std::string prefix = path + ": ";
  diagnostic.message =
      error.message.starts_with(prefix) ? error.message.substr(prefix.size()) : error.message;
  report(diagnostic, error.missing || error.unsuitable ? Exit::invalid : Exit::internal);
}

void Session::note(Exit reason) { reasons_ |= bit_of(reason); }

bool Session::has(Exit reason) const { return (reasons_ & bit_of(reason)) != 0; }

int Session::exit_code() const {
  for (const Exit reason : kPriority) {
    if (reason == Exit::warnings && strict && warnings_ > 0) return static_cast<int>(reason);
    if (has(reason)) return static_cast<int>(reason);
  }
  return 0;
}

Diagnostic option_error(std::string_view option, std::string message, std::string fix) {
  return about_option(Severity::error, option, std::move(message), std::move(fix));
}

Diagnostic option_warning(std::string_view option, std::string message, std::string fix) {
  return about_option(Severity::warning, option, std::move(message), std::move(fix));
}

void catch_signals() {
  unreadable = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  struct sigaction stop = {};
  stop.sa_handler = request_stop;
  stop.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &stop, nullptr);
  sigaction(SIGTERM, &stop, nullptr);
  struct sigaction ignore = {};
  ignore.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &ignore, nullptr);
  sigaction(SIGXFSZ, &ignore, nullptr);
}

bool interrupted() { return stop_requested != 0; }

}  // namespace abbe::app
