#pragma once

#include "abbe/chain/plan.h"

namespace abbe {

/// The length up to which a straight move of linear axes needs no look inside: the tip's error stays within
/// `bend` (mm) of the straight line between its values at the ends. A bound, not a sample:
///
///   |E(s) - chord| <= L^2/8 K + L/4 J
///   K = sum over error factors of |d''| + |e''| R + 2 |e'|,   J = sum of the largest slope jumps
///
/// d, e   tabulated displacement and rotation of a factor, derivatives by its axis position, largest values
///        within the travels (5 m either side where none is given), components added up
/// R      the length of the chain with the farthest `measured_at`: no point of it is farther from the tip
/// A move shorter than the distance of two knots with a slope jump crosses one of them per table.
/// Rotary axes stand still. Returns 0 if some error is not tabulated, or makes a step: then nothing is
/// known.
/// laws   ErrorsBendNoMoreThanTheBound FarMeasuringPointsLengthenTheLever AStepHasNoReach
[[nodiscard]] double straight_reach(const Plan& plan, const Tool& tool, double bend);

}  // namespace abbe
