#pragma once

#include <string>
#include <vector>

#include "abbe/core/linear_algebra.h"

namespace abbe {

/// A rational B-spline as a program states it:
///
///   C(u) = sum_i N_i(u) w_i P_i / sum_i N_i(u) w_i
///
/// order    degree + 1: how many control points a place depends on
/// knots    never decreasing, points.size() + order of them; the first `order` are equal and the last, so
///          that the curve begins at the first point and ends at the last
/// weights  above zero
/// laws     ItBeginsAndEndsAtItsPoints, AnAffineMovementIsExact
/// source   L. Piegl, W. Tiller: The NURBS Book, 2nd ed., 4.1
struct NurbsCurve {
  int order = 4;
  std::vector<double> knots, weights;
  std::vector<Vec3> points;  ///< mm
};

/// Why the curve is none; empty: it is one.
[[nodiscard]] std::string fault_of(const NurbsCurve& curve);

/// C(u) by de Boor's algorithm in homogeneous coordinates; u within the knots. cost   order^2 / 2 averages
[[nodiscard]] Vec3 place_on(const NurbsCurve& curve, double u);

/// The mean of the inner knots of control point i: where the curve follows that point most (Greville).
///   u_i = (t_{i+1} + .. + t_{i+p}) / p,  p = order - 1
[[nodiscard]] double greville(const NurbsCurve& curve, std::size_t i);

/// How far each control point must be moved for the curve to move by wanted[i] at greville(i):
///
///   sum_j R_j(u_i) d_j = wanted_i,  by d := d + (wanted - R d) until that is below a nanometre
///
/// Exact along the whole curve where the movement is an affine function of the place, whatever the weights.
/// For cubics the steps shrink to about a third each; what they leave is for the caller to judge.
/// cost     at most 80 evaluations per control point
[[nodiscard]] std::vector<Vec3> shifts_through(const NurbsCurve& curve, const std::vector<Vec3>& wanted);

}  // namespace abbe
