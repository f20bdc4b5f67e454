#pragma once

#include <string>

#include "abbe/report/program_report.h"

namespace abbe {

/// The picture of a corrected program, one page that prints in black and white as well:
///
///   left    the tool path on the workpiece, coloured by the deviation before (um, distance of the tip)
///   right   the same path after, on the same scale
///   below   the deviation x, y, z along the path before, and after on its own scale with what is allowed
///
/// The path is seen from above the plane of its two largest extents, or isometrically if it is as
/// deep as wide. Rapids are thin and grey. Flat, tiny and single-point paths have their picture too; one
/// without feed motions says so.
///
/// errors   none; samples that are not finite are left out
/// laws     SameInputSameBytes, WellFormedForAnySamples
/// cost     one pass over report.verify->samples; the file grows with the samples shown (at most
///          4000)
[[nodiscard]] std::string figure_before_after(const ProgramReport& report);

}  // namespace abbe
