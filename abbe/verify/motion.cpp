#include "abbe/verify/motion.h"

#include <cmath>

namespace abbe::verifying {

Vec3 point_at(const Motion& motion, double s) {
  if (motion.kind != MotionKind::arc) return motion.start.at + s * (motion.end.at - motion.start.at);
  const Arc& arc = motion.arc;
  const double angle = arc.start_angle + arc.sweep * s;
  const double radius = arc.start_radius + (arc.end_radius - arc.start_radius) * s;
  return arc.centre + radius * (arc.first * std::cos(angle) + arc.second * std::sin(angle)) +
         arc.normal * (arc.rise * s);
}

Vec3 derivative_at(const Motion& motion, double s) {
  if (motion.kind != MotionKind::arc) return motion.end.at - motion.start.at;
  const Arc& arc = motion.arc;
  const double angle = arc.start_angle + arc.sweep * s;
  const double radius_rate = arc.end_radius - arc.start_radius;
  const double radius = arc.start_radius + radius_rate * s;
  const Vec3 outward = arc.first * std::cos(angle) + arc.second * std::sin(angle);
  const Vec3 along = arc.second * std::cos(angle) - arc.first * std::sin(angle);
  return radius_rate * outward + radius * arc.sweep * along + arc.normal * arc.rise;
}

double length_of_arc(const Arc& arc) {
  const double mean_radius = 0.5 * (arc.start_radius + arc.end_radius);
  return std::hypot(mean_radius * arc.sweep, arc.end_radius - arc.start_radius, arc.rise);
}

}  // namespace abbe::verifying
