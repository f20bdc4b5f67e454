#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/fit/fit_job.h"
#include "abbe/fit/function_model.h"
#include "abbe/fit/observations.h"

namespace abbe {

/// An unknown function of the machine: its mean over both directions of approach, and what reversal adds:
///
///   f(v, approach) = mean(v) + approach * reversal(v) / 2
struct UnknownFunction {
  std::string name;
  int axis = 0;
  bool rotation = false;
  double position_unit = 1;  ///< mm or rad per number of the model
  double error_unit = 1;
  FunctionModel mean;
  std::optional<FunctionModel> reversal;  ///< none: not measured in both directions, or not asked for
};

/// What a fit looks for. Location errors are constants.
struct Unknowns {
  std::vector<UnknownFunction> functions;
  std::vector<std::string> locations;
  bool locations_asked = false;  ///< named by the job: one that is not determined is a warning then
};

/// The unknowns of a job: a function for every error that has runs, in the form the job says (cross-validated
/// over its own runs if it says nothing), and for those declared that diagonals or points reach; location
/// errors as asked for, else those that its measurements can show.
///
///   zero at the reference position; straightness without trend (it is squareness)
///   linear axes: X before Y before Z by direction; the first one is the datum, of the second one the
///   squareness to it, of the third one both; rotary axes: displacements and rotations perpendicular to the
///   axis
///
/// errors   E-JOB-FORM (a declared function that needs runs, or a form with more unknowns than targets),
///          E-ERRORS-SEEN (errors of a workpiece-branch axis that does not state errors_seen)
[[nodiscard]] Parsed<Unknowns> unknowns_of(const FitJob& job, const Observations& observations);

}  // namespace abbe
