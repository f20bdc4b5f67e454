#pragma once

#include <cmath>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

namespace abbe {

/// Equally spaced samples of one quantity, in its unit.
using Samples = std::vector<double>;

/// Why a record cannot be worked on.
enum class SignalProblem {
  too_short,       ///< fewer samples than the method needs
  not_finite,      ///< a sample that is no number, or larger than kLargestSample
  sizes_differ,    ///< records that belong together have different lengths
  not_increasing,  ///< times or angles that do not rise
  bad_option,      ///< an option outside what its comment allows
  constant,        ///< nothing varies, so nothing can be found
  no_overlap,      ///< what is asked for lies outside the record
  not_converged,   ///< the iteration did not settle
};

/// A sentence without a full stop: "the record is too short for this method".
[[nodiscard]] std::string_view to_string(SignalProblem problem);

/// A value, or the one reason why there is none.
template <class T>
using SignalResult = std::variant<T, SignalProblem>;

/// Larger samples are refused: their squares would not be finite.
inline constexpr double kLargestSample = 1e100;

/// True if every sample is a number of magnitude at most kLargestSample.
[[nodiscard]] inline bool all_finite(std::span<const double> y) {
  bool finite = true;  // no early end: the loop runs in vectors
  for (const double value : y) finite &= std::abs(value) <= kLargestSample;
  return finite;
}

}  // namespace abbe
