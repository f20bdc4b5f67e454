#pragma once

#include <optional>
#include <vector>

#include "abbe/core/progress.h"
#include "abbe/surface/nearest.h"

namespace abbe {

/// A point that a measuring machine touched, part axes, mm, probe radius already taken off.
struct TouchedPoint {
  Vec3 measured = Vec3::Zero();
  std::optional<SurfacePlace> target;  ///< where on the nominal surface it was meant to be, if that is known
};

/// How the measured points are brought to the nominal surface before they are judged.
enum class BestFit {
  none,   ///< as they are: the datum of the part is that of the program
  shift,  ///< moved by the best translation
  rigid,  ///< moved by the best translation and rotation
};

/// One point, judged.
struct InspectedPoint {
  Vec3 measured = Vec3::Zero();  ///< after the fit
  SurfaceFoot foot;              ///< on the nominal surface
  double linear = 0;             ///< mm: distance to the target; to the foot after a fit or without target
  bool used = true;              ///< false: beside the patch, or no normal there; not part of fit and figures
};

/// What is said of all points used, mm.
///
///     mean, rms, least, most   of the deviations d along the outward normal, + = material left on
///     profile                  2 max |d|: width of the zone about the nominal surface that holds all points
///                              (ISO 1101 profile of a surface, the zone equally disposed)
///     range                    most - least: the same with a zone that may lie anywhere
///     linear                   mean distance between point and target, the "total linear error"; after a fit
///     to the
///                              foot, for a fit does not tell how the surface slid within itself
///     creased                  points used whose foot is on a crease: d is their distance, with a sign
struct InspectionFigures {
  std::size_t count = 0, beside = 0, creased = 0;
  double mean = 0, rms = 0, least = 0, most = 0, profile = 0, range = 0;
  double linear = 0, linear_most = 0;
};

struct Inspection {
  std::vector<InspectedPoint> points;
  InspectionFigures figures;
  Vec3 shift = Vec3::Zero();  ///< of the fit, at the middle of the points, mm
  Vec3 turn = Vec3::Zero();   ///< rotation vector of the fit, rad
  int rank = 0;               ///< motions of the fit that the points tell; the others were left out
  bool settled = true;        ///< false: the fit still moved after kMostFits rounds
  bool stopped = false;       ///< by `progress`: nothing else is of use
};

inline constexpr int kMostFits = 30;

/// Of the points with `used`; least = most = 0 without any.
[[nodiscard]] InspectionFigures figures_of(const std::vector<InspectedPoint>& points);

/// Deviations of measured points from the nominal surface, along its normals.
///
/// The fit minimises the sum of d^2 over d, e:  q' = q + d + e x (q - c), row n.(d + e x (q - c)) = -d_i,
/// least norm where the points do not tell (a plane: two shifts and one rotation), repeated with new feet
/// until it stands.
///
/// beside    points farther than this off the rim of the patch do not count, mm
/// progress  of points; without a total while a fit goes on
/// errors    no points: figures of zeros. Points are finite.
/// laws      APoleCounts, StopsWhenAsked, AMovedPartFitsBack, PointsOnTheSurfaceHaveNoDeviation,
///           APlaneTellsThreeMotions
/// cost      a nearest point per point and round
[[nodiscard]] Inspection inspect_points(const NearestPoint& nominal, const std::vector<TouchedPoint>& points,
                                        BestFit fit, double beside = 0.1, const Progress& progress = {});

}  // namespace abbe
