#include "abbe/surface/surface_check.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "abbe/surface/nearest.h"

namespace abbe {
namespace {

constexpr std::size_t kMostCells = 64;

/// A net of places on the surface, row by row in u.
struct Net {
  std::vector<double> u, v;
  std::vector<Vec3> points;
  [[nodiscard]] const Vec3& at(std::size_t i, std::size_t j) const { return points[i * v.size() + j]; }
};

std::vector<double> at_most(const NurbsSurface& surface, std::size_t direction, std::size_t pieces) {
  std::vector<double> at = span_samples(surface, direction, pieces);
  if (at.size() <= kMostCells + 1) return at;
  const auto [lo, hi] = surface.range(direction);
  at.clear();
  for (std::size_t k = 0; k <= kMostCells; ++k)
    at.push_back(lo + (hi - lo) * static_cast<double>(k) / static_cast<double>(kMostCells));
  return at;
}

Net net_of(const NurbsSurface& surface, std::size_t pieces) {
  Net net;
  net.u = at_most(surface, 0, pieces);
  net.v = at_most(surface, 1, pieces);
  for (const double u : net.u)
    for (const double v : net.v) net.points.push_back(evaluate(surface, {u, v}).p);
  return net;
}

SurfacePlace middle(const Net& net, std::size_t i, std::size_t j) {
  return {(net.u[i] + net.u[i + 1]) / 2, (net.v[j] + net.v[j + 1]) / 2};
}

/// Normals at the middle of the cells: there must be some, and neighbours must agree.
std::optional<SurfaceFault> find_bad_normal(const NurbsSurface& surface, const Net& net) {
  const std::size_t rows = net.u.size() - 1, columns = net.v.size() - 1;
  std::vector<Vec3> normals;
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < columns; ++j) {
      const SurfacePlace place = middle(net, i, j);
      const SurfacePoint s = evaluate(surface, place);
      if (!s.is_regular()) return SurfaceFault{SurfaceFault::Kind::degenerate, place, place, s.p};
      normals.push_back(s.normal);
      const Vec3* const here = &normals.back();
      const bool folded = (j > 0 && here[-1].dot(s.normal) < 0) ||
                          (i > 0 && normals[normals.size() - 1 - columns].dot(s.normal) < 0);
      if (folded) return SurfaceFault{SurfaceFault::Kind::folded, place, place, s.p};
    }
  }
  return std::nullopt;
}

/// A triangle of the net: its corners, their box and the cell it belongs to.
struct Facet {
  std::array<Vec3, 3> at;
  Vec3 low, high;
  std::size_t i = 0, j = 0;
};

std::vector<Facet> facets_of(const Net& net) {
  std::vector<Facet> facets;
  for (std::size_t i = 0; i + 1 < net.u.size(); ++i) {
    for (std::size_t j = 0; j + 1 < net.v.size(); ++j) {
      const Vec3 &a = net.at(i, j), &b = net.at(i + 1, j), &c = net.at(i + 1, j + 1), &d = net.at(i, j + 1);
      for (const std::array<Vec3, 3>& at : {std::array{a, b, c}, std::array{a, c, d}})
        facets.push_back(
            {at, at[0].cwiseMin(at[1]).cwiseMin(at[2]), at[0].cwiseMax(at[1]).cwiseMax(at[2]), i, j});
    }
  }
  return facets;
}

/// Does the segment a-b pass through the triangle? Touching its plane counts as not.
bool passes_through(const Vec3& a, const Vec3& b, const std::array<Vec3, 3>& t) {
  const Vec3 e1 = t[1] - t[0], e2 = t[2] - t[0], d = b - a;
  const Vec3 h = d.cross(e2);
  const double det = e1.dot(h);
  if (std::abs(det) <= 1e-12 * e1.norm() * e2.norm() * d.norm()) return false;
  // a + s d = t0 + x e1 + y e2
  const Vec3 from = a - t[0];
  const double x = from.dot(h) / det;
  const Vec3 q = from.cross(e1);
  const double y = d.dot(q) / det, s = e2.dot(q) / det;
  return x >= 0 && y >= 0 && x + y <= 1 && s > 0 && s < 1;
}

bool cut_each_other(const Facet& a, const Facet& b) {
  if ((a.low.array() > b.high.array()).any() || (b.low.array() > a.high.array()).any()) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    if (passes_through(a.at[k], a.at[(k + 1) % 3], b.at)) return true;
    if (passes_through(b.at[k], b.at[(k + 1) % 3], a.at)) return true;
  }
  return false;
}

bool are_neighbours(const Facet& a, const Facet& b) {
  const auto near = [](std::size_t x, std::size_t y) { return (x > y ? x - y : y - x) <= 1; };
  return near(a.i, b.i) && near(a.j, b.j);
}

/// A closed surface meets itself along its seam without passing through: only places apart from it count.
bool is_seam(const Facet& a, const Facet& b) {
  for (const Vec3& p : a.at)
    for (const Vec3& q : b.at)
      if ((p - q).norm() <= 1e-9 * (a.high - a.low).norm()) return true;
  return false;
}

/// Sweep along x: only facets whose boxes overlap there are compared.
std::optional<SurfaceFault> find_crossing(const Net& net) {
  std::vector<Facet> facets = facets_of(net);
  std::sort(facets.begin(), facets.end(),
            [](const Facet& a, const Facet& b) { return a.low.x() < b.low.x(); });
  for (std::size_t n = 0; n < facets.size(); ++n) {
    const Facet& a = facets[n];
    for (std::size_t m = n + 1; m < facets.size() && facets[m].low.x() <= a.high.x(); ++m) {
      const Facet& b = facets[m];
      if (are_neighbours(a, b) || !cut_each_other(a, b) || is_seam(a, b)) continue;
      return SurfaceFault{SurfaceFault::Kind::intersecting, middle(net, a.i, a.j), middle(net, b.i, b.j),
                          a.at[0]};
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<SurfaceFault> find_fault(const NurbsSurface& surface, std::size_t pieces) {
  const Net net = net_of(surface, pieces);
  if (auto fault = find_bad_normal(surface, net)) return fault;
  return find_crossing(net);
}

std::string to_text(const SurfaceFault& fault) {
  const std::string at = fmt::format("at u {:.4g}, v {:.4g} (x {:.3f}, y {:.3f}, z {:.3f})", fault.place.u,
                                     fault.place.v, fault.point.x(), fault.point.y(), fault.point.z());
  switch (fault.kind) {
    case SurfaceFault::Kind::degenerate:
      return "the surface has no normal " + at;
    case SurfaceFault::Kind::folded:
      return "the surface is folded " + at;
    case SurfaceFault::Kind::intersecting:
      break;
  }
  return fmt::format("the surface cuts itself {} and at u {:.4g}, v {:.4g}", at, fault.other.u,
                     fault.other.v);
}

}  // namespace abbe
