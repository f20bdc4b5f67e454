#pragma once

#include <string>
#include <vector>

#include "abbe/fit/fit_job.h"
#include "abbe/fit/joint_fit.h"

namespace abbe {

/// A machine measured at one temperature.
struct ThermalState {
  double temperature = 0;  ///< degC, of the sensor
  FitResult result;
};

/// An errors file, or why there is none.
struct StateGrids {
  std::string text;
  std::string obstacle;  ///< empty: `text` is an errors file
};

/// The errors of one machine measured in several thermal states, as functions of position and temperature:
///
///   functions    bilinear grids over 33 positions of the axis and the temperatures of the states
///   locations    tables over the temperatures
///   reversal     the mean of all states, a number or a table over the same positions: how it depends on
///                temperature is not asked
///
/// `states` in increasing order of temperature, two at least; outside of them the end value is held, and said
/// to be. What is written of functions between the positions is their straight line; the largest bend that
/// cuts off is in a comment.
///
/// errors   obstacle: a function, its reversal or a location that is not in every state, or a function that
///          was not seen over a common travel
/// laws     GridMeetsEveryStateAndTheirMeanBetween, ReversalIsTheMeanOfAllStates
[[nodiscard]] StateGrids write_state_grids(const FitJob& job, const std::string& sensor,
                                           const std::vector<ThermalState>& states);

}  // namespace abbe
