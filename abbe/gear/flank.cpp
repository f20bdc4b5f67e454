#include "abbe/gear/flank.h"

#include <Eigen/Geometry>
#include <cmath>

namespace abbe {
namespace {

/// A modification and its derivatives along roll length and z.
struct Modification {
  double value = 0, by_roll_length = 0, by_z = 0;
};

void add_tip_relief(const Gear& gear, double roll, Modification& m) {
  if (!(gear.spec.tip_relief > 0)) return;
  // m = -C (1 - (L_a - L) / l) over the last roll length l
  const double from_tip = gear.base_radius * (gear.tip_roll - roll);
  if (from_tip >= gear.spec.tip_relief_length) return;
  m.value -= gear.spec.tip_relief * (1 - from_tip / gear.spec.tip_relief_length);
  m.by_roll_length -= gear.spec.tip_relief / gear.spec.tip_relief_length;
}

void add_profile_crowning(const Gear& gear, double roll, Modification& m) {
  // m = -C u^2,  u = -1 at the form diameter, +1 at the tip
  const double half = 0.5 * gear.base_radius * (gear.tip_roll - gear.form_roll);
  const double u = gear.base_radius * (roll - 0.5 * (gear.tip_roll + gear.form_roll)) / half;
  m.value -= gear.spec.profile_crowning * u * u;
  m.by_roll_length -= 2 * gear.spec.profile_crowning * u / half;
}

Modification modification_at(const Gear& gear, double roll, double z, Modified modified) {
  Modification m;
  if (modified == Modified::none) return m;
  add_tip_relief(gear, roll, m);
  add_profile_crowning(gear, roll, m);
  if (modified == Modified::all) {
    m.value += helix_modification(gear, z);
    // d/dz of -C (2 z / b)^2
    m.by_z = -8 * gear.spec.helix_crowning * z / (gear.spec.face_width * gear.spec.face_width);
  }
  return m;
}

Vec3 turned(const Vec3& v, double cosine, double sine) {
  return {cosine * v.x() - sine * v.y(), sine * v.x() + cosine * v.y(), v.z()};
}

}  // namespace

double profile_modification(const Gear& gear, double roll) {
  return modification_at(gear, roll, 0, Modified::profile).value;
}

double helix_modification(const Gear& gear, double z) {
  const double u = 2 * z / gear.spec.face_width;
  return -gear.spec.helix_crowning * u * u;
}

FlankPoint flank_point(const Gear& gear, Flank flank, double roll, double z, Modified modified) {
  const double s = side_of_gap(flank), rb = gear.base_radius, kappa = gear.turn_per_mm;
  const double phi = roll + gear.half_gap - involute_of_roll(gear.reference_roll);
  const double cosine = std::cos(phi), sine = std::sin(phi);
  const Modification m = modification_at(gear, roll, z, modified);
  const Vec3 along(cosine, s * sine, 0), tangent(sine, -s * cosine, 0);
  // P + m t
  const Vec3 p = rb * Vec3(cosine + roll * sine, s * (sine - roll * cosine), 0) + m.value * tangent;
  // dP/dL = (xi + m / r_b) u + m_L t,   dP/dz = kappa e_z x P + e_z + m_z t
  const Vec3 by_roll = (roll + m.value / rb) * along + m.by_roll_length * tangent;
  const Vec3 by_z = kappa * Vec3(-p.y(), p.x(), 0) + Vec3::UnitZ() + m.by_z * tangent;
  Vec3 normal = by_roll.cross(by_z);
  // On the base circle the first derivative vanishes; the unmodified normal is its limit.
  if (!(normal.norm() > 1e-9)) normal = tangent + s * kappa * rb * Vec3::UnitZ();
  normal.normalize();
  if (normal.dot(tangent) < 0) normal = -normal;
  const double turn = kappa * z, c = std::cos(turn), sn = std::sin(turn);
  return {turned(p, c, sn) + Vec3(0, 0, z), turned(normal, c, sn), turned(tangent, c, sn)};
}

}  // namespace abbe
