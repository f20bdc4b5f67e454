#include "run_program.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

namespace abbe::cli {
namespace {

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::vector<std::string> words_of(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {program_path()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

/// For execv, as long as `words` live.
std::vector<char*> argv_of(std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  return argv;
}

int exit_of(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

bool catches(pid_t child, int signal) {
  const std::string status = content("/proc/" + std::to_string(child) + "/status");
  const std::size_t at = status.find("SigCgt:");
  return at != std::string::npos &&
         (std::stoull(status.substr(at + 7), nullptr, 16) >> (signal - 1) & 1) != 0;
}

}  // namespace

std::string program_path() {
  const char* const named = std::getenv("ABBE_PROGRAM");
  return named != nullptr ? named : ABBE_PROGRAM;
}

Folder::Folder() {
  std::string pattern = std::filesystem::temp_directory_path() / "abbe-cli-XXXXXX";
  path_ = ::mkdtemp(pattern.data()) != nullptr ? pattern : std::string();
}

Folder::~Folder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

std::string Folder::put(std::string_view name, std::string_view text) const {
  const std::string path = *this / name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

ProgramRun run_abbe(const std::vector<std::string>& arguments, std::string_view input,
                    const std::string& folder) {
  const Folder scratch;
  const std::string in = scratch.put("in", input), out = scratch / "out", err = scratch / "err";
  std::vector<std::string> words = words_of(arguments);
  const std::vector<char*> argv = argv_of(words);
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(::open(in.c_str(), O_RDONLY), STDIN_FILENO);
    ::dup2(::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDOUT_FILENO);
    ::dup2(::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
    if (::chdir(folder.c_str()) == 0) ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  ProgramRun run;
  run.exit = exit_of(child);
  run.out = content(out);
  run.err = content(err);
  return run;
}

int interrupt_abbe(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = words_of(arguments);
  const std::vector<char*> argv = argv_of(words);
  const pid_t child = ::fork();
  if (child == 0) {
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  for (int k = 0; k < 1000 && !catches(child, SIGINT); ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ::kill(child, SIGINT);
  return exit_of(child);
}

}  // namespace abbe::cli
