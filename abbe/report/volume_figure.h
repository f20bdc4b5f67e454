#pragma once

#include <string>

#include "abbe/volume/map.h"

namespace abbe {

/// The overview of a map, one page that prints in black and white as well:
///
///   above  up to three slices through the point of the largest deviation, coloured by the distance |d| of
///   the
///          tip (um), with a ring at that point and strokes that show the part of d within the slice
///   left   error budget: rms and largest effect of each error alone, the largest first
///   right  figures of the deviation, ranges, and how much too long the diagonals are
///
/// One varying axis gives its deviation as three lines in place of the slices; a single point says so.
/// `map.status` is done.
///
/// errors   none
/// laws     SameInputSameBytes, WellFormedForAnyGrid
/// cost     a grid of more than 64 positions along an axis is thinned evenly
[[nodiscard]] std::string figure_of_volume(const Machine& machine, const VolumeQuestion& question,
                                           const VolumeMap& map);

}  // namespace abbe
