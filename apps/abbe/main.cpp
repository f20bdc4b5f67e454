// abbe: makes machine tools more accurate than they were built. One file per verb; this one reads
// the command line, runs the verb and turns what happened into an exit code.

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "session.h"
#include "verbs.h"

namespace abbe::app {
namespace {

constexpr const char* kFooter =
    "\nExit codes: 0 done, 1 internal or I/O, 2 usage or input invalid, 3 refused, 4 warnings under "
    "--strict,\n"
    "5 outside the calibrated volume or the travels, 6 verification failed, 130 interrupted.";

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// The misspelt word of the command line and what it was probably meant to be; empty if none is.
std::string spelling_hint(const CLI::App& program, const std::vector<std::string>& words) {
  const CLI::App* command = nullptr;
  for (const std::string& word : words) {
    if (word.starts_with("--") && word.size() > 2) {
      const std::string name = word.substr(0, word.find('='));
      const std::vector<std::string> known = option_names(command != nullptr ? *command : program);
      if (std::find(known.begin(), known.end(), name) != known.end()) continue;
      const std::optional<std::string> like = closest(name, known);
      return fmt::format("unknown option {}{}", name, like ? fmt::format("; did you mean {}?", *like) : "");
    }
    const std::vector<const CLI::App*> kinds = (command != nullptr ? *command : program).get_subcommands({});
    if (kinds.empty() || word.starts_with("-")) continue;
    std::vector<std::string> names;
    const CLI::App* found = nullptr;
    for (const CLI::App* kind : kinds) {
      if (kind->get_name() == word) found = kind;
      names.push_back(kind->get_name());
    }
    if (found == nullptr) {
      const std::optional<std::string> like = closest(word, names);
      return fmt::format("unknown verb '{}'{}", word, like ? fmt::format("; did you mean {}?", *like) : "");
    }
    command = found;
  }
  return {};
}

int usage_error(const CLI::App& program, const std::vector<std::string>& words,
                const CLI::ParseError& error) {
  std::string message = spelling_hint(program, words);
  if (message.empty()) message = error.what();
  std::string help = "abbe --help";
  for (const CLI::App* verb : program.get_subcommands())
    help = fmt::format("abbe {} --help", verb->get_name());
  fmt::print(stderr, "abbe: error[E-USAGE]: {}\n  = fix: see {}\n", message, help);
  return static_cast<int>(Exit::invalid);
}

int run(int argc, char** argv) {
  Session session;
  Command program(
      "abbe: describe a machine tool, predict its deviation, correct its commands and programs.\n", "abbe");
  program.parser().set_version_flag("--version", "abbe " ABBE_VERSION);
  program.require_subcommand(1);
  program.parser().footer(kFooter);
  const std::array verbs = {
      describe_verb(program, session),   predict_verb(program, session),
      map_verb(program, session),        correct_verb(program, session),
      inverse_verb(program, session),    cl_correct_verb(program, session),
      derive_verb(program, session),     signcheck_verb(program, session),
      compensate_verb(program, session), check_verb(program, session),
      verify_verb(program, session),     toolpath_verb(program, session),
      machine_verb(program, session),    inspect_verb(program, session),
      diff_verb(program, session),       explain_verb(program, session),
      profiles_verb(program, session),   capture_verb(program, session),
      filter_verb(program, session),     ballbar_verb(program, session),
      identify_verb(program, session),   identifiability_verb(program, session),
      evaluate_verb(program, session),   fit_verb(program, session),
      simulate_verb(program, session),   gear_verb(program, session),
  };
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    program.parser().parse(argc, argv);
  } catch (const CLI::Success& asked) {
    // --help and --version: their text goes to standard output like any other answer.
    if (dynamic_cast<const CLI::CallForVersion*>(&asked) != nullptr) {
      session.out.write("abbe " ABBE_VERSION "\n");
    } else {
      session.out.write(program.parser().help());
    }
    session.out.flush();
    return static_cast<int>(session.out.ok() ? Exit::done : Exit::internal);
  } catch (const CLI::ParseError& error) {
    return usage_error(program.parser(), words, error);
  }

  catch_signals();
  for (const Verb& verb : verbs) {
    if (verb.command->parsed()) verb.run();
  }
  session.out.flush();
  if (interrupted()) session.note(Exit::interrupted);
  if (!session.out.ok()) {
    if (!session.out.closed_by_reader())
      fmt::print(stderr, "abbe: standard output: {}\n", session.out.error_text());
    session.note(Exit::internal);
  }
  return session.exit_code();
}

}  // namespace
}  // namespace abbe::app

int main(int argc, char** argv) {
  try {
    return abbe::app::run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("abbe: out of memory\n", stderr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "abbe: internal error: %s\n", error.what());
  } catch (...) {
    std::fputs("abbe: internal error\n", stderr);
  }
  return static_cast<int>(abbe::app::Exit::internal);
}
