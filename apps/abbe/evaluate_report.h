#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "abbe/evaluate/diagonal_figures.h"
#include "abbe/evaluate/drift.h"
#include "abbe/evaluate/positioning.h"
#include "abbe/evaluate/positioning_uncertainty.h"
#include "abbe/evaluate/straightness.h"
#include "abbe/report/measurement_figure.h"
#include "session.h"

namespace abbe::app {

/// What the command line says about how a positioning test was set up.
struct SetupArguments {
  double instrument_ppm = 0, misalignment_mm = 0, temperature_range = 0, expansion_ppm = 0;
  double expansion_range_ppm = 0, temperature_difference = 0, environment_um = 0;
  int trials = 0;
  std::uint64_t seed = 1;
};

/// Figures of one file of runs.
struct RunAnswer {
  std::string file, as;
  Quantity target_quantity = Quantity::length, quantity = Quantity::length;
  PositioningFigures figures;
  std::optional<StraightnessFigures> straightness;  ///< of the means, if that was asked for
  std::vector<UncertaintyInput> budget;             ///< of positioning
  std::optional<PositioningUncertainty> drawn;
};
[[nodiscard]] std::optional<RunAnswer> answer_of_runs(const std::string& as, const RunTable& table,
                                                      const SetupArguments& setup, Session& session);
[[nodiscard]] std::vector<FigureFact> facts_of(const RunAnswer& answer);
[[nodiscard]] std::string text_of(const RunAnswer& answer);
[[nodiscard]] std::string json_of(const RunAnswer& answer);

/// Figures of diagonals, and the squareness they show if the sides are known.
struct DiagonalAnswer {
  std::vector<std::string> files;
  DiagonalFigures figures;
  std::optional<double> face;
  std::optional<BodyDiagonals> box;
};
[[nodiscard]] DiagonalAnswer answer_of_diagonals(const std::vector<std::string>& files,
                                                 const std::vector<RunTable>& tables,
                                                 const std::vector<double>& sides);
[[nodiscard]] std::string text_of(const DiagonalAnswer& answer);
[[nodiscard]] std::string json_of(const DiagonalAnswer& answer);

[[nodiscard]] std::vector<FigureFact> facts_of(const DriftFigures& figures);
[[nodiscard]] std::string text_of(const std::string& file, const DriftFigures& figures);
[[nodiscard]] std::string json_of(const std::string& file, const DriftFigures& figures);

}  // namespace abbe::app
