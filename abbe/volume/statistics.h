#pragma once

#include <cstddef>
#include <vector>

#include "abbe/core/linear_algebra.h"
#include "abbe/volume/field.h"

namespace abbe {

/// Smallest of the values that at least `part` of all of them do not exceed (nearest rank, exact):
/// the k-th smallest with k = ceil(part n), at least 1. 0 of no values. 0 <= part <= 1.
[[nodiscard]] double percentile(std::vector<double> values, double part);

inline constexpr double kPercentile = 0.95;

/// Values (mm, rad) that differ by less are equally large, so that rounding does not choose the place of the
/// largest: of equally large ones the first is named.
inline constexpr double kSameValue = 1e-10;

/// Of values that are not negative (distances, angles), one per grid point.
struct Amount {
  double max = 0, rms = 0, mean = 0, percentile95 = 0;
  std::size_t at = 0;  ///< the point of the largest value
};
[[nodiscard]] Amount amount_of(const std::vector<double>& values);

/// Of values with a sign (components), one per grid point. `percentile95` is of the magnitudes.
struct Spread {
  double min = 0, max = 0, rms = 0, mean = 0, percentile95 = 0;
  std::size_t at_min = 0, at_max = 0;
  [[nodiscard]] double range() const { return max - min; }
};
[[nodiscard]] Spread spread_of(const std::vector<double>& values);

/// Figures of a field that do not depend on where the workpiece is touched off, in the manner of ISO 230-1
/// (volumetric accuracy V): the range over the volume of the relative deviation between actual and ideal
/// position along x, y, z, and of the orientation about x, y, z. Six numbers, not one.
struct VolumetricAccuracy {
  Vec3 position = Vec3::Zero();     ///< max - min of the deviation along x y z, mm
  Vec3 orientation = Vec3::Zero();  ///< max - min of the rotation about x y z, rad
};

/// The rigid motion of the workpiece that agrees best with a field: least sum over the points of
/// |d - t - w x (p - centre)|^2. What no rotation of the points can show (one point, points on a
/// line) stays zero in w.
struct Alignment {
  Vec3 centre = Vec3::Zero();  ///< mean of the nominal tips, mm
  Vec3 t = Vec3::Zero();       ///< displacement of the centre, mm
  Vec3 w = Vec3::Zero();       ///< rotation, rad
  [[nodiscard]] Vec3 at(const Vec3& p) const { return t + w.cross(p - centre); }
};
[[nodiscard]] Alignment best_fit(const DeviationField& field);

/// laws     RangesDoNotDependOnTheDatum; after best_fit no rigid motion is left (BestFitLeavesNoRigidMotion)
[[nodiscard]] VolumetricAccuracy volumetric_accuracy(const DeviationField& field,
                                                     const Alignment& alignment = {});

/// Everything about the deviations of one field, or of what is left when `alignment` or a datum is taken
/// away.
struct FieldFigures {
  std::array<Spread, 3> component;  ///< along x y z, mm
  Amount length;                    ///< distance of the tip, mm
};
[[nodiscard]] FieldFigures figures_of(const DeviationField& field, const Alignment& alignment = {});

}  // namespace abbe
