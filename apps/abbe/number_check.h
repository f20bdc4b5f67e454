#pragma once

#include "command_line.h"

namespace abbe::app {

/// Checks for options that are numbers. nan, inf and what is no number are refused; CLI11's own Range,
/// NonNegativeNumber and PositiveNumber let nan through.
[[nodiscard]] OptionCheck number_in(double least, double most);
[[nodiscard]] OptionCheck not_negative();
[[nodiscard]] OptionCheck above_zero();

}  // namespace abbe::app
