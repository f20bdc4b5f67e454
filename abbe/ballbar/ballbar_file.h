#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "abbe/ballbar/trace.h"
#include "abbe/core/diagnostic.h"

namespace abbe {

/// What a bare CSV file does not say, from the command line. The file wins where both say it
/// (W-BALLBAR where they differ).
struct BallbarDefaults {
  std::optional<TestPlane> plane;
  std::optional<double> radius;  ///< mm
  std::optional<double> feed;    ///< mm/s
  std::optional<int> direction;  ///< +1, -1
};

/// Reads a ball-bar test: lines "# key: value" (plane, radius_mm, feed_mm_per_min, centre_mm, noise_um,
/// setup, machine, instrument, date), then a CSV table. Columns, in any order:
///
///   angle_deg                                 required
///   deviation_um | deviation_mm | radius_mm   one of them; radius_mm is the measured length
///   time_s, run, direction (CCW | CW), x_mm y_mm z_mm, x_cmd_mm y_cmd_mm z_cmd_mm
///
/// A new value in `run` or `direction` begins a new run; without them the sense of the angle tells the
/// direction. Angles may wrap at a turn. Cells are separated by comma, semicolon or tab.
///
/// errors   every finding has its place. Refused: angles that jump, stand still or go to and fro, lengths
///          that are not those of this radius, positions that are not on the circle (swapped axes), times
///          that do not increase, cells that are no finite numbers, fewer than kFewestSamples per run
/// laws     WhatIsWrittenReadsBack; total on any bytes
/// cost     one pass
[[nodiscard]] Parsed<BallbarTest> read_ballbar(const std::string& file, std::string_view text,
                                               const BallbarDefaults& defaults = {});

inline constexpr std::size_t kFewestSamples = 12;

/// The same format; every number reads back to the same double after the change of unit.
[[nodiscard]] std::string write_ballbar(const BallbarTest& test);

}  // namespace abbe
