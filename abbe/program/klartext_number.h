#pragma once

#include <cstddef>
#include <string_view>

namespace abbe {

/// A number of a conversational program: "+10.5", "-0,25"; the comma counts as a point.
struct KlartextNumber {
  double value = 0;
  int decimals = 0;        ///< digits after the point
  std::size_t length = 0;  ///< bytes; 0: no literal number that ends there
  bool comma = false;
};
/// Reads the number at the start of `text`, up to a blank or the end.
[[nodiscard]] KlartextNumber read_klartext_number(std::string_view text);

}  // namespace abbe
