#pragma once

#include <array>
#include <vector>

#include "abbe/core/linear_algebra.h"
#include "abbe/evaluate/positioning.h"

namespace abbe {

/// Runs along diagonals in the manner of ISO 230-6: the figures of ISO 230-2 along each, the largest of all.
struct DiagonalFigures {
  std::vector<PositioningFigures> diagonals;  ///< in the order given
  double E_d = 0;                             ///< largest E of a diagonal
  double B_d = 0;                             ///< largest B of a diagonal
};
[[nodiscard]] DiagonalFigures diagonal_figures(const std::vector<RunTable>& diagonals);

/// Squareness of a plane from how much too long its face diagonals are:
///
///   C = (dL_np - dL_pp) L / (2 a b),  L = sqrt(a^2 + b^2)
///
/// pp rises in both axes (of lengths a and b), np rises in the second while the first falls. C > 0 turns the
/// second axis from the first one to its negative side: E_C0Y of the plane XY, E_A0Z of YZ, but -E_B0Z of ZX.
/// Which axis is the first does not matter: -+ and +- are one diagonal.
///
/// units    mm to rad
/// source   docs/theory/measurement.md (first order)
[[nodiscard]] double squareness_of_face(double a, double b, double longer_pp, double longer_np);

/// The three squareness angles from the four body diagonals of a box of sides L = (x, y, z), rad. `longer` is
/// in the order +++, -++, +-+, ++-: the sign in which each axis proceeds. First order, by least squares:
///
///   dL = s . D / |L|  with D = C0Y (-s_y Ly, 0, 0) + B0Z (s_z Lz, 0, 0) + A0Z (0, -s_z Lz, 0)
///
/// One value per diagonal cannot tell them from linear errors of the axes that differ by axis: the common
/// part of the four is `mean_longer`, which the angles leave alone.
struct BodyDiagonals {
  double C0Y = 0, B0Z = 0, A0Z = 0;
  double mean_longer = 0;
};
[[nodiscard]] BodyDiagonals squareness_of_box(const Vec3& sides, const std::array<double, 4>& longer);

}  // namespace abbe
