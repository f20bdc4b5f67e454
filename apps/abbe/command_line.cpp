#include "command_line.h"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <utility>

namespace abbe::app {
namespace {

OptionCheck check_of(const CLI::Validator& validator) {
  return {[validator](const std::string& text) { return validator(text); }, validator.get_description()};
}

}  // namespace

OptionCheck one_of(std::vector<std::string> words) { return check_of(CLI::IsMember(std::move(words))); }

OptionCheck whole_in(int least, int most) { return check_of(CLI::Range(least, most)); }

Option* Option::required(bool value) {
  option_->required(value);
  return this;
}

Option* Option::check(const OptionCheck& check) {
  option_->check(CLI::Validator([check](std::string& text) { return check.complaint(text); }, check.wanted));
  return this;
}

Option* Option::type_name(const std::string& name) {
  option_->type_name(name);
  return this;
}

Option* Option::group(const std::string& name) {
  option_->group(name);
  return this;
}

Option* Option::delimiter(char between) {
  option_->delimiter(between);
  return this;
}

Option* Option::allow_extra_args(bool value) {
  option_->allow_extra_args(value);
  return this;
}

Option* Option::capture_default_str() {
  option_->capture_default_str();
  return this;
}

Option* Option::excludes(Option* other) {
  option_->excludes(other->option_);
  return this;
}

std::size_t Option::count() const { return option_->count(); }

Command::Command(const std::string& description, const std::string& name)
    : app_(std::make_shared<CLI::App>(description, name)) {}

Command* Command::add_subcommand(const std::string& name, const std::string& description) {
  // Owned by the App above it, which lives as long.
  std::shared_ptr<CLI::App> app(app_, app_->add_subcommand(name, description));
  below_.push_back(std::unique_ptr<Command>(new Command(std::move(app))));
  return below_.back().get();
}

template <class T>
Option* Command::add_option(const std::string& name, T& value, const std::string& description) {
  return keep(app_->add_option(name, value, description));
}

Option* Command::add_flag(const std::string& name, bool& value, const std::string& description) {
  return keep(app_->add_flag(name, value, description));
}

Option* Command::get_option(const std::string& name) {
  const CLI::Option* const wanted = app_->get_option_no_throw(name);
  for (const auto& option : options_) {
    if (option->is(wanted)) return option.get();
  }
  return nullptr;
}

void Command::require_subcommand(int how_many) { app_->require_subcommand(how_many); }

bool Command::parsed() const { return app_->parsed(); }

Option* Command::keep(CLI::Option* option) {
  options_.push_back(std::make_unique<Option>(option));
  return options_.back().get();
}

template Option* Command::add_option(const std::string&, std::string&, const std::string&);
template Option* Command::add_option(const std::string&, int&, const std::string&);
template Option* Command::add_option(const std::string&, double&, const std::string&);
template Option* Command::add_option(const std::string&, unsigned&, const std::string&);
template Option* Command::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option* Command::add_option(const std::string&, std::optional<int>&, const std::string&);
template Option* Command::add_option(const std::string&, std::optional<double>&, const std::string&);
template Option* Command::add_option(const std::string&, std::vector<int>&, const std::string&);
template Option* Command::add_option(const std::string&, std::vector<double>&, const std::string&);
template Option* Command::add_option(const std::string&, std::vector<std::string>&, const std::string&);

}  // namespace abbe::app
