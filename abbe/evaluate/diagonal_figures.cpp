#include "abbe/evaluate/diagonal_figures.h"

#include <algorithm>
#include <cmath>

namespace abbe {

DiagonalFigures diagonal_figures(const std::vector<RunTable>& diagonals) {
  DiagonalFigures out;
  for (const RunTable& table : diagonals) {
    const PositioningFigures& figures = out.diagonals.emplace_back(positioning_figures(table));
    out.E_d = std::max(out.E_d, figures.E.both);
    out.B_d = std::max(out.B_d, figures.B);
  }
  return out;
}

double squareness_of_face(double a, double b, double longer_pp, double longer_np) {
  // dL_pp = -C a b / L, dL_np = +C a b / L
  return (longer_np - longer_pp) * std::hypot(a, b) / (2 * a * b);
}

BodyDiagonals squareness_of_box(const Vec3& sides, const std::array<double, 4>& longer) {
  // The products of signs of +++, -++, +-+, ++-: three patterns, each orthogonal to the others and to the
  // mean.
  static constexpr std::array<std::array<double, 3>, 4> kSigns = {
      {{1, 1, 1}, {-1, 1, 1}, {1, -1, 1}, {1, 1, -1}}};
  const double length = sides.norm();
  double xy = 0, xz = 0, yz = 0;
  BodyDiagonals out;
  for (std::size_t i = 0; i < kSigns.size(); ++i) {
    const auto& s = kSigns[i];
    xy += s[0] * s[1] * longer[i] / 4;
    xz += s[0] * s[2] * longer[i] / 4;
    yz += s[1] * s[2] * longer[i] / 4;
    out.mean_longer += longer[i] / 4;
  }
  // dL = (-s_x s_y Lx Ly C0Y + s_x s_z Lx Lz B0Z - s_y s_z Ly Lz A0Z) / |L|
  out.C0Y = -xy * length / (sides.x() * sides.y());
  out.B0Z = xz * length / (sides.x() * sides.z());
  out.A0Z = -yz * length / (sides.y() * sides.z());
  return out;
}

}  // namespace abbe
