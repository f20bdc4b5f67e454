#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "abbe/chain/predict.h"
#include "abbe/core/progress.h"
#include "abbe/gear/wheel.h"

namespace abbe {

/// What was wrong with the wheel's place while it cut: its displacement d (mm) and small rotation e (rad)
/// against the gear, at its centre, at evenly spaced heights of the stroke in every gap.
///
/// The axes are those of the gap at the height of the wheel: x radial, y tangential, z the gear axis. In this
/// frame, which turns with the helix, all gaps and heights are alike.
struct WheelDeviations {
  double low = 0, high = 0;   ///< heights of the wheel's centre above the middle of the face, mm
  std::size_t nodes = 0;      ///< at least 4
  std::vector<Twist> values;  ///< gap by gap, `nodes` of each

  WheelDeviations() = default;
  /// None anywhere.
  WheelDeviations(double from, double to, std::size_t nodes_of_gap, int gaps)
      : low(from), high(to), nodes(nodes_of_gap), values(nodes_of_gap * static_cast<std::size_t>(gaps)) {}

  [[nodiscard]] double height(std::size_t node) const {
    return low + (high - low) * static_cast<double>(node) / static_cast<double>(nodes - 1);
  }
  [[nodiscard]] Twist& of(std::size_t gap, std::size_t node) { return values[gap * nodes + node]; }
  [[nodiscard]] const Twist& of(std::size_t gap, std::size_t node) const {
    return values[gap * nodes + node];
  }
};

/// Four neighbours and their weights: cubic interpolation on even nodes, at the ends one-sided.
struct NodeWeights {
  std::size_t first = 0;
  std::array<double, 4> weight{};
};
[[nodiscard]] NodeWeights node_weights(const WheelDeviations& deviations, double height);

/// How far the wheel goes in beyond its nominal depth to crown the face: radial, mm, not positive. The
/// design's helix modification at this height over the sine under which a radial shift meets the flank at the
/// reference cylinder. Beyond the face and the reach of the contacts it stays.
[[nodiscard]] double crowning_infeed(const Gear& gear, const WheelInGap& wheel, double height);

/// Deviation of the flank from its design, transverse along the base tangent, mm, + = excess material:
///
///     f(xi, z) = W(xi) . (d, e)(t) + W_x(xi) c(t) - m(z),   t = z - z_contact(xi)
///
/// first order in the deviations (cut_exactly of exact_cut.h is not); c is the infeed that crowns the face
/// and m what the design wants of it: across the profile the two differ even without errors.
///
/// gap      from 0
/// z        from the middle of the face, mm
/// laws     PerfectMachineMakesAPerfectGear, DeviationsAreSuperposed, SingleErrorsHaveTheirClosedForms
[[nodiscard]] double flank_deviation(const Gear& gear, const WheelInGap& wheel,
                                     const WheelDeviations& deviations, std::size_t gap,
                                     const WheelContact& contact, double z);

/// The deviations of all flanks: of every gap both flanks (right first), of each the rolls of the wheel's
/// contacts, of each the heights z. Empty if `progress` stopped it.
/// cost     about 10 ns per point and core; 8 bytes per point
[[nodiscard]] std::vector<double> flank_field(const Gear& gear, const WheelInGap& wheel,
                                              const WheelDeviations& deviations, const std::vector<double>& z,
                                              const Progress& progress = {});

/// `count` heights evenly over the face.
[[nodiscard]] std::vector<double> even_heights(const Gear& gear, int count);

}  // namespace abbe
