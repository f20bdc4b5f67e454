#pragma once

#include <string>

#include "abbe/ballbar/circular_figures.h"
#include "abbe/ballbar/diagnosis.h"

namespace abbe {

/// The picture of a circular test, one page that prints in black and white as well:
///
///   left   polar plot: the nominal circle, one trace per run (counter-clockwise solid, clockwise dashed),
///          deviations magnified; one ring is a round number of um; the fit of the diagnosis thin in grey
///   right  causes by their effect on the radius, the largest first, with value and uncertainty
///
/// errors   none; a test without runs shows the rings
/// laws     SameInputSameBytes, WellFormed
/// cost     runs of more than 3600 samples are thinned evenly
[[nodiscard]] std::string figure_of_ballbar(const BallbarTest& test, const TestFigures& figures,
                                            const Diagnosis& diagnosis);

/// A term for people: "6.02", "um" and "0.05" of the uncertainty.
struct TermText {
  std::string value, uncertainty, unit;
};
[[nodiscard]] TermText text_of(const DiagnosisTerm& term);

}  // namespace abbe
