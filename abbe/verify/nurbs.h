#pragma once

#include <vector>

#include "abbe/core/linear_algebra.h"

namespace abbe::verifying {

/// A curve by control points as a control makes it of G6.2: the sum of its points, each with its share.
///
///   share_i(u) = N_i(u) w_i / sum_j N_j(u) w_j,  N_i of Cox and de Boor, of this order (degree + 1)
///
/// source   M. Cox, J. Inst. Maths Applics 10 (1972) 134
struct Nurbs {
  int order = 0;
  std::vector<double> knots, weights;
  std::vector<Vec3> points;  ///< machine coordinates as in Motion, mm
};

/// It begins at its first point and ends at its last, and all its places are defined.
[[nodiscard]] bool is_curve(const Nurbs& nurbs);

/// The place at u, from the first knot to the last. cost   points * order, or less: shares of zero are left
/// out
[[nodiscard]] Vec3 point_of(const Nurbs& nurbs, double u);

}  // namespace abbe::verifying
