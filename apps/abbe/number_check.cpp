#include "number_check.h"

#include <fmt/format.h>

#include <string>

#include "abbe/core/number.h"

namespace abbe::app {
namespace {

/// `what` says which numbers `accepts` takes: 'is not a number WHAT'.
template <class Accepts>
OptionCheck check(const Accepts& accepts, const std::string& what) {
  return {[accepts, what](const std::string& text) {
            const auto value = read_number(text);
            return value && accepts(*value) ? std::string()
                                            : fmt::format("'{}' is not a number {}", text, what);
          },
          what};
}

}  // namespace

OptionCheck number_in(double least, double most) {
  return check([=](double value) { return value >= least && value <= most; },
               fmt::format("from {:g} to {:g}", least, most));
}

OptionCheck not_negative() {
  return check([](double value) { return value >= 0; }, "of 0 or more");
}

OptionCheck above_zero() {
  return check([](double value) { return value > 0; }, "above 0");
}

}  // namespace abbe::app
