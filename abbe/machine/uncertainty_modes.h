#pragma once

#include <vector>

#include "abbe/machine/machine.h"
#include "abbe/machine/read_machine.h"

namespace abbe {

/// How the errors of a file are uncertain together: independent numbers z of mean 0 and standard deviation 1,
/// one per mode,
///
///   errors = stated errors + sum_m z_m mode_m,   covariance = sum_m mode_m mode_m^T
///
/// A mode is a set of errors with functions like those of [errors].
struct UncertaintyModes {
  std::vector<std::vector<ErrorTerm>> modes;
  std::vector<Variable> variables;  ///< of all functions: those of the machine first, at the same places
};

/// The [[uncertainty_mode]] tables of `text`, the file that `machine` has its errors from; and for every
/// error with an [uncertainty] that is in none of them a mode of its own: one number for its whole travel.
///
/// errors   those of [errors]; E-UNCERTAINTY: a mode of an error that has no value
/// laws     ModesAddUpToTheCovariance, ErrorsWithoutModesHaveTheirOwn
[[nodiscard]] Parsed<UncertaintyModes> read_uncertainty_modes(const Machine& machine, const MachineText& text,
                                                              const FileFetcher& fetch);

}  // namespace abbe
