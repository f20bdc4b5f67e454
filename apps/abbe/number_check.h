#pragma once

#include <CLI/CLI.hpp>

namespace abbe::app {

/// Checks for options that are numbers. nan, inf and what is no number are refused; CLI11's own Range,
/// NonNegativeNumber and PositiveNumber let nan through.
[[nodiscard]] CLI::Validator number_in(double least, double most);
[[nodiscard]] CLI::Validator not_negative();
[[nodiscard]] CLI::Validator above_zero();

}  // namespace abbe::app
