#include "abbe/evaluate/positioning_uncertainty.h"

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

using Kind = Distribution::Kind;

double length_of(const PositioningFigures& figures) {
  return figures.targets.back().position - figures.targets.front().position;
}

/// What the axis did beyond every reading alike: d(deviation) = scale * (position - first) + per run an
/// offset. A beam at an angle to the axis shows too little travel: the axis went further, never less far.
std::vector<Distribution> setup_inputs(const PositioningSetup& setup, const PositioningFigures& figures) {
  const double length = length_of(figures);
  const double cosine = setup.misalignment * setup.misalignment / (2 * length * length);
  std::vector<Distribution> inputs = {
      {Kind::normal, 0, setup.instrument_relative},
      {Kind::rectangular, cosine / 2, cosine / 2},
      {Kind::rectangular, 0, setup.expansion * setup.temperature_range / 2},
      {Kind::rectangular, 0, setup.temperature_difference * setup.expansion_range / 2}};
  return inputs;
}

constexpr std::size_t kScales = 4;

/// The mean of n readings with standard deviation s: Student's distribution of width s / sqrt(n).
Distribution mean_of(double s, int runs) {
  return {Kind::student, 0, s / std::sqrt(runs), static_cast<double>(runs - 1)};
}

}  // namespace

std::vector<UncertaintyInput> positioning_budget(const PositioningSetup& setup,
                                                 const PositioningFigures& figures) {
  const double length = length_of(figures);
  std::vector<UncertaintyInput> budget = {
      {"instrument", setup.instrument_relative, length},
      // A beam counts L cos(R / L), up to R^2 / (2 L) too little and never too much.
      {"misalignment", uncertainty_of_range(setup.misalignment * setup.misalignment / (2 * length)), 1},
      {"temperature", uncertainty_of_range(setup.temperature_range), setup.expansion * length},
      {"expansion", uncertainty_of_range(setup.expansion_range), setup.temperature_difference * length},
      {"environment", uncertainty_of_range(setup.environment_variation), 1}};
  const int runs = std::max(figures.runs_forward, figures.runs_backward);
  if (runs < 2) return budget;
  double scatter = 0;
  for (const PositioningTarget& target : figures.targets)
    scatter = std::max({scatter, target.s_forward, target.s_backward});
  budget.push_back({"repeatability", scatter / std::sqrt(runs), 1, static_cast<double>(runs - 1)});
  return budget;
}

std::optional<PositioningUncertainty> positioning_uncertainty(const RunTable& table,
                                                              const PositioningSetup& setup,
                                                              std::size_t trials, std::uint64_t seed) {
  const PositioningFigures figures = positioning_figures(table);
  if (!figures.has_spread()) return std::nullopt;
  const Eigen::Index targets = table.target_count(), up = table.forward.cols(), down = table.backward.cols();
  std::vector<Distribution> inputs = setup_inputs(setup, figures);
  const Distribution offset{Kind::rectangular, 0, setup.environment_variation / 2};
  inputs.insert(inputs.end(), static_cast<std::size_t>(up + down), offset);
  for (const PositioningTarget& target : figures.targets) {
    if (up > 0) inputs.push_back(mean_of(target.s_forward, figures.runs_forward));
    if (down > 0) inputs.push_back(mean_of(target.s_backward, figures.runs_backward));
  }
  const auto model = [&](const std::vector<double>& drawn) {
    RunTable moved = table;
    double scale = 0;
    for (std::size_t i = 0; i < kScales; ++i) scale += drawn[i];
    const auto run_offset = Eigen::Map<const Eigen::RowVectorXd>(drawn.data() + kScales, up + down);
    const double* mean = drawn.data() + kScales + up + down;
    for (Eigen::Index i = 0; i < targets; ++i) {
      const double along = scale * (table.targets[static_cast<std::size_t>(i)] - table.targets.front());
      if (up > 0) moved.forward.row(i).array() += along + run_offset.head(up).array() + *mean++;
      if (down > 0) moved.backward.row(i).array() += along + run_offset.tail(down).array() + *mean++;
    }
    const PositioningFigures drawn_figures = positioning_figures(moved);
    return std::vector<double>{drawn_figures.E.both, drawn_figures.A.both, drawn_figures.M, drawn_figures.B};
  };
  const std::vector<MonteCarloResult> results = propagate(inputs, model, trials, 0.95, seed);
  if (results.size() != 4) return std::nullopt;
  return PositioningUncertainty{results[0], results[1], results[2], results[3]};
}

}  // namespace abbe
