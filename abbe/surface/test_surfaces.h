#pragma once

// Surfaces with known answers. Test support.

#include <array>
#include <cmath>
#include <string>

#include "abbe/surface/nurbs.h"

namespace abbe {

/// x from 0 to `length`, y from 0 to `width`, at the height z = slope_x x + slope_y y; the material below.
inline NurbsSurface plane_patch(double length, double width, double slope_x = 0, double slope_y = 0) {
  NurbsSurface plane;
  plane.knots = {uniform_knots(2, 1), uniform_knots(2, 1)};
  for (const double x : {0.0, length})
    for (const double y : {0.0, width}) plane.points.emplace_back(x, y, slope_x * x + slope_y * y);
  plane.weights.assign(4, 1.0);
  return plane;
}

/// Three points and weights of an arc of radius r about 0 from angle a to b (less than half a turn), in a
/// plane.
struct ArcNet {
  std::array<std::array<double, 2>, 3> at;
  std::array<double, 3> weight;
};
inline ArcNet arc_net(double r, double a, double b) {
  const double half = (b - a) / 2, middle = (a + b) / 2, w = std::cos(half);
  return {{{{r * std::cos(a), r * std::sin(a)},
            {r / w * std::cos(middle), r / w * std::sin(middle)},
            {r * std::cos(b), r * std::sin(b)}}},
          {1, w, 1}};
}

/// A trough or (hollow = false) a hump: y from 0 to `length`, a circle of radius r about the axis (0, y, 0)
/// over `half` rad to both sides of straight down or up. The material is outside of the trough, inside of the
/// hump.
inline NurbsSurface cylinder_patch(double r, double half, double length, bool hollow) {
  NurbsSurface cylinder;
  cylinder.degree = {2, 1};
  cylinder.count = {3, 2};
  cylinder.knots = {uniform_knots(3, 2), uniform_knots(2, 1)};
  const ArcNet arc = arc_net(r, -half, half);  // first axis: z, second: x
  for (std::size_t i = 0; i < 3; ++i) {
    for (const double y : {0.0, length}) {
      cylinder.points.emplace_back(arc.at[i][1], y, hollow ? -arc.at[i][0] : arc.at[i][0]);
      cylinder.weights.push_back(arc.weight[i]);
    }
  }
  return cylinder;
}

/// A patch of a sphere of radius r about 0: the profile from `from` to `to` rad off the pole, turned through
/// `turn` rad about z. hollow: the lower half, material outside; else the upper half, material inside.
inline NurbsSurface sphere_patch(double r, double from, double to, double turn, bool hollow) {
  NurbsSurface sphere;
  sphere.degree = {2, 2};
  sphere.count = {3, 3};
  sphere.knots = {uniform_knots(3, 2), uniform_knots(3, 2)};
  const ArcNet profile = arc_net(r, from, to), round = arc_net(1, 0, turn);
  const double side = hollow ? -1 : 1;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double out = profile.at[i][1];
      sphere.points.emplace_back(out * round.at[j][0], out * round.at[j][1], side * profile.at[i][0]);
      sphere.weights.push_back(profile.weight[i] * round.weight[j]);
    }
  }
  return sphere;
}

/// A roof of two slopes of 45 degrees, ridge up along y at x = 0; valley: upside down.
inline NurbsSurface roof_patch(bool valley) {
  NurbsSurface roof;
  roof.degree = {1, 1};
  roof.count = {3, 2};
  roof.knots = {std::vector<double>{0, 0, 1, 2, 2}, uniform_knots(2, 1)};
  const double side = valley ? 10 : -10;
  for (const Vec3& p : {Vec3(-10, 0, side), Vec3(0, 0, 0), Vec3(10, 0, side)})
    for (const double y : {0.0, 20.0}) roof.points.push_back(p + Vec3(0, y, 0));
  roof.weights.assign(6, 1.0);
  return roof;
}

/// A wavy bicubic patch, x and y from 0 to 60, some mm high, the material below; every patch of a seed is
/// another.
inline NurbsSurface wavy_patch(unsigned seed) {
  NurbsSurface patch;
  patch.degree = {3, 3};
  patch.count = {6, 7};
  patch.knots = {uniform_knots(6, 3), uniform_knots(7, 3)};
  unsigned state = seed * 2654435761u + 1;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 7; ++j) {
      state = state * 1664525u + 1013904223u;
      const double noise = static_cast<double>(state >> 8) / static_cast<double>(1u << 24);
      patch.points.emplace_back(12.0 * i, 10.0 * j, 4 * noise);
      patch.weights.push_back(0.8 + 0.4 * noise);
    }
  }
  return patch;
}

}  // namespace abbe
