#pragma once

#include <string>

#include "abbe/part/inspection.h"

namespace abbe {

/// Colour map of an inspected surface, seen from above the plane of its two largest extents: lines of the
/// nominal surface, every point used as a dot, light where the deviation is small, red where material is left
/// on, blue where too much is cut, and the scale and figures beside it. Points that do not count are hollow.
///
/// errors   none; without points the page says so
/// laws     SameInputSameBytes, WellFormedForAnyPoints, SignShowsInColour
/// cost     one element per point (at most 10000 are drawn, evenly chosen)
[[nodiscard]] std::string figure_of_inspection(const NurbsSurface& surface, const Inspection& inspection);

}  // namespace abbe
