#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "abbe/evaluate/monte_carlo.h"
#include "abbe/evaluate/positioning.h"
#include "abbe/evaluate/uncertainty.h"

namespace abbe {

/// How a linear positioning test was set up, for the uncertainty of its result.
struct PositioningSetup {
  double instrument_relative = 0;     ///< standard uncertainty of the instrument's scale, 1
  double misalignment = 0;            ///< most that beam and axis are apart over the length, mm
  double temperature_range = 0;       ///< width of what the material's temperature may be, K
  double expansion = 0;               ///< coefficient of the material, 1/K
  double expansion_range = 0;         ///< width of what it may be, 1/K
  double temperature_difference = 0;  ///< of the material from 20 degC, K
  double environment_variation = 0;   ///< drift of the set-up over the test, mm
};

/// Contributions to the uncertainty of the mean deviation over the full length:
///
///   instrument u_r L, misalignment R^2 / (2 L), temperature alpha L dT, expansion (T - 20) L d(alpha),
///   environment, repeatability s / sqrt(n)
///
/// ranges are taken as rectangular. In the manner of ISO/TR 230-9, whose text was not at hand.
/// laws     MisalignmentIsThatOfTheRuleOfThumb
[[nodiscard]] std::vector<UncertaintyInput> positioning_budget(const PositioningSetup& setup,
                                                               const PositioningFigures& figures);

/// Figures drawn with everything that is not known of the set-up and with the means of the runs (Student's
/// distribution); the spread of the runs is what was measured.
struct PositioningUncertainty {
  MonteCarloResult E, A, M, B;
};

/// errors   nullopt: a direction has only one run
/// laws     ExactSetUpLeavesTheScatterOfMeans
/// cost     trials * (targets * runs)
[[nodiscard]] std::optional<PositioningUncertainty> positioning_uncertainty(const RunTable& table,
                                                                            const PositioningSetup& setup,
                                                                            std::size_t trials,
                                                                            std::uint64_t seed);

}  // namespace abbe
