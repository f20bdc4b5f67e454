#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace abbe {

/// The lines of a subprogram that stands in the file of the program that calls it.
struct Subprogram {
  std::uint64_t first_line = 0;    ///< of "O2000", from 1
  std::vector<std::string> lines;  ///< with their end-of-line bytes, up to the next O or the end of the file
};

/// Finds "O2000" at the start of a line, behind the main program or before it, but not behind a closing '%'.
/// errors   nullopt: it is not there, there twice, longer than kMostLines lines, or the file cannot be read
/// cost     one pass over the file
inline constexpr std::size_t kMostSubprogramLines = 200000;
[[nodiscard]] std::optional<Subprogram> find_subprogram(const std::string& path, int number);

/// Finds "LBL 5" of a conversational program, up to the next "LBL 0". errors, cost   as find_subprogram
[[nodiscard]] std::optional<Subprogram> find_label(const std::string& path, std::string_view label);

}  // namespace abbe
