#include "abbe/cl/motion.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace abbe::cl {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kSameAngle = 1e-9;  // rad: a start on the end, as far as doubles tell
constexpr double kSamePoint = 1e-7;  // mm

Vec3 across(const Vec3& v, const Vec3& normal) { return v - normal * normal.dot(v); }

Vec3 point_on(const Arc& arc, const Vec3& start, double s) {
  const Vec3 u = across(start - arc.centre, arc.normal).normalized();
  const double radius = arc.start_radius + (arc.end_radius - arc.start_radius) * s, angle = arc.sweep * s;
  return arc.centre + radius * (std::cos(angle) * u + std::sin(angle) * arc.normal.cross(u)) +
         arc.normal * (arc.rise * s);
}

}  // namespace

Vec3 between(const Vec3& a, const Vec3& b, double s) {
  const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
  if (angle < 1e-9) return (a + s * (b - a)).normalized();
  // slerp
  return ((std::sin((1 - s) * angle) * a + std::sin(s * angle) * b) / std::sin(angle)).normalized();
}

ToolPose pose_at(const Motion& motion, double s) {
  if (s <= 0) return motion.start;
  if (s >= 1) return motion.end;
  ToolPose pose;
  pose.tip = motion.kind == MotionKind::arc
                 ? point_on(motion.arc, motion.start.tip, s)
                 : Vec3(motion.start.tip + s * (motion.end.tip - motion.start.tip));
  pose.axis = between(motion.start.axis, motion.end.axis, s);
  return pose;
}

double length_of(const Motion& motion) {
  if (motion.kind != MotionKind::arc) return (motion.end.tip - motion.start.tip).norm();
  const Arc& arc = motion.arc;
  return std::hypot(0.5 * (arc.start_radius + arc.end_radius) * arc.sweep, arc.rise);
}

double turn_of(const Motion& motion) {
  return std::atan2(motion.start.axis.cross(motion.end.axis).norm(), motion.start.axis.dot(motion.end.axis));
}

Arc make_arc(const Vec3& centre, const Vec3& normal, const Vec3& start, const Vec3& end, int turns) {
  Arc arc;
  arc.normal = normal;
  arc.centre = centre + normal * normal.dot(start - centre);
  arc.rise = normal.dot(end - start);
  const Vec3 u = across(start - centre, normal), v = across(end - centre, normal);
  arc.start_radius = u.norm();
  arc.end_radius = v.norm();
  arc.sweep = std::atan2(normal.dot(u.cross(v)), u.dot(v));
  const bool closed = (u - v).norm() < kSamePoint || std::abs(arc.sweep) < kSameAngle;
  if (closed) arc.sweep = 0;
  if (arc.sweep <= 0) arc.sweep += kTurn;
  // TIMES n: n turns in all for a helix that ends over its start, else n - 1 whole ones and the rest
  arc.sweep += kTurn * (turns - 1);
  return arc;
}

}  // namespace abbe::cl
