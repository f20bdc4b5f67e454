#pragma once

#include <vector>

#include "abbe/fit/function_model.h"

namespace abbe {

/// A mean deviation at a target.
struct CoursePoint {
  double position = 0, value = 0;
};

/// What points say of a form that is fitted without them.
struct LeftOut {
  double mean_square = 0;  ///< of the differences, each point left out once
  double u = 0;            ///< standard uncertainty of that mean
};

/// The fit has a free offset, and a free slope if the gauge has no trend. Positions in the units of the form.
/// A form with more unknowns than the points left over gives infinity. cost     points * parameters^2
[[nodiscard]] LeftOut left_out(const FunctionForm& form, const FunctionGauge& gauge,
                               const std::vector<CoursePoint>& course);

/// The simplest form that cross-validation cannot tell from the best one: its mean square is within one
/// standard uncertainty of the least. Polynomials of order 1 to `most_order` come first, then natural cubic
/// splines through 4, 6, 8 .. values, evenly spaced over the range. laws     FindsTheOrderOfAPolynomial,
/// TakesASplineWhereNoPolynomialFits source   the one-standard-error rule: Hastie, Tibshirani, Friedman:
/// Elements of Statistical Learning, 7.10
[[nodiscard]] FunctionForm choose_form(const FunctionGauge& gauge, const std::vector<CoursePoint>& course,
                                       int most_order);

/// `count` positions from lo to hi, equally spaced.
[[nodiscard]] std::vector<double> even_nodes(double lo, double hi, std::size_t count);

}  // namespace abbe
