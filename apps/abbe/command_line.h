#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// The command line as the verbs see it. CLI11 is behind it, in command_line.cpp and main.cpp only: it is all
/// headers, and every file that included it would compile it again (5 s a verb).
namespace abbe::app {

/// What the text of an option must be.
struct OptionCheck {
  std::function<std::string(const std::string&)> complaint;  ///< empty: the text is good
  std::string wanted;                                        ///< shown by --help
};
/// One of these words.
[[nodiscard]] OptionCheck one_of(std::vector<std::string> words);
/// A whole number, least <= it <= most.
[[nodiscard]] OptionCheck whole_in(int least, int most);

/// An option, a flag or a positional argument; owned by its Command. Each setter answers the option itself.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option* required(bool value = true);
  Option* check(const OptionCheck& check);
  Option* type_name(const std::string& name);
  Option* group(const std::string& name);
  Option* delimiter(char between);  ///< several values in one text
  Option* allow_extra_args(bool value);
  Option* capture_default_str();  ///< --help shows the value that the variable has now
  Option* excludes(Option* other);
  [[nodiscard]] std::size_t count() const;  ///< how often it was given
  [[nodiscard]] bool is(const CLI::Option* option) const { return option_ == option; }

 private:
  CLI::Option* option_;
};

/// The program, a verb or a verb's verb: its options and what is below it, which it owns.
class Command {
 public:
  Command(const std::string& description, const std::string& name);
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  Command* add_subcommand(const std::string& name, const std::string& description);
  /// `value` is written when the line is read and must live until then. T: a number, std::string,
  /// std::optional and std::vector of them; the list ends command_line.cpp.
  template <class T>
  Option* add_option(const std::string& name, T& value, const std::string& description);
  Option* add_flag(const std::string& name, bool& value, const std::string& description);
  /// An option that was added here; nullptr if none has the name.
  [[nodiscard]] Option* get_option(const std::string& name);
  void require_subcommand(int how_many);
  [[nodiscard]] bool parsed() const;
  /// What reads the line; for main.cpp.
  [[nodiscard]] CLI::App& parser() const { return *app_; }

 private:
  explicit Command(std::shared_ptr<CLI::App> app) : app_(std::move(app)) {}
  Option* keep(CLI::Option* option);

  std::shared_ptr<CLI::App> app_;
  std::vector<std::unique_ptr<Option>> options_;
  std::vector<std::unique_ptr<Command>> below_;
};

}  // namespace abbe::app
