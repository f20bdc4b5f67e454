#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "abbe/program/hole_cycle.h"

namespace abbe {

/// A drilling cycle with its numbers in brackets, CYCLE81 to CYCLE89 and CYCLE840:
///
///   CYCLE81(RTP, RFP, SDIS, DP, DPR, ..)
///
/// top = RFP + SDIS, bottom = DP or RFP - DPR, clear = RTP; RTP, RFP and DP are places along Z, program
/// units. source   SINUMERIK programming guide Cycles (PGZ) 11.02; modes behind the classic numbers as CAM
/// posts of
///          2021 write them
struct BracketCycle {
  static constexpr std::size_t kMost = 24;
  struct Argument {
    bool said = false;
    double value = 0;
    int decimals = 0;
    std::size_t begin = 0, end = 0;  ///< in `text`
  };
  int number = 0;    ///< 81 to 89, 840
  std::string text;  ///< "CYCLE81(50, 0, 2, -20)"
  std::array<Argument, kMost> arguments{};
  std::size_t count = 0;
  HoleSpan span;

  [[nodiscard]] double surface() const { return arguments[1].value; }  ///< RFP
  /// Most digits after the point of its places.
  [[nodiscard]] int decimals() const;
  /// The text with all places moved by `shift`, a number of `digits` digits at least those of decimals().
  [[nodiscard]] std::string moved(double shift, int digits) const;
};

/// The cycle, or why it is not followed: an argument that is no literal number, a mode that is not known, DP
/// and DPR that say two depths, planes that are not one above the other.
struct BracketAnswer {
  std::optional<BracketCycle> cycle;
  std::string message;  ///< where there is none
};
/// Reads "CYCLE81(..)". cost     one allocation
[[nodiscard]] BracketAnswer read_bracket_cycle(std::string_view code);

/// "CYCLE81" and so on, capitals: the number of a cycle that is known here, or 0.
[[nodiscard]] int bracket_cycle_number(std::string_view name);

}  // namespace abbe
