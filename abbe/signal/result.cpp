#include "abbe/signal/result.h"

namespace abbe {

std::string_view to_string(SignalProblem problem) {
  switch (problem) {
    case SignalProblem::too_short:
      return "the record is too short for this method";
    case SignalProblem::not_finite:
      return "a sample is not a number, or too large";
    case SignalProblem::sizes_differ:
      return "records that belong together have different lengths";
    case SignalProblem::not_increasing:
      return "the times do not rise from sample to sample";
    case SignalProblem::bad_option:
      return "an option is outside its range";
    case SignalProblem::constant:
      return "the record does not vary, so there is nothing to find";
    case SignalProblem::no_overlap:
      return "what is asked for lies outside the record";
    case SignalProblem::not_converged:
      break;
  }
  return "the iteration did not settle";
}

}  // namespace abbe
