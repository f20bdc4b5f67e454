#pragma once

#include <variant>

#include "abbe/gear/wheel_deviations.h"

// Gears of the tests. Test support.

namespace abbe::test {

/// The gear of seed 002: module 12 mm, 94 teeth, 20 degrees, spur.
inline GearSpec seed_spec() {
  GearSpec spec;
  spec.module = 12;
  spec.teeth = 94;
  spec.face_width = 100;
  return spec;
}

/// A helical one.
inline GearSpec helical_spec(int hand = 1) {
  GearSpec spec;
  spec.module = 4;
  spec.teeth = 41;
  spec.helix_angle = 15 * deg;
  spec.hand = hand;
  spec.profile_shift = 0.2;
  spec.face_width = 60;
  return spec;
}

inline Gear gear_of(const GearSpec& spec) { return std::get<Gear>(make_gear(spec)); }

inline WheelInGap wheel_of(const Gear& gear, int rolls = 21, double diameter = 300) {
  WheelSpec spec;
  spec.diameter = diameter;
  return std::get<WheelInGap>(fit_wheel(gear, spec, even_rolls(gear, rolls)));
}

/// No deviation anywhere, over the stroke that the face needs.
inline WheelDeviations none(const Gear& gear, const WheelInGap& wheel, std::size_t nodes = 33) {
  const double far = gear.spec.face_width / 2 + wheel.reach;
  return {-far, far, nodes, gear.spec.teeth};
}

/// The same displacement and rotation everywhere.
inline WheelDeviations everywhere(const Gear& gear, const WheelInGap& wheel, const Twist& twist) {
  WheelDeviations out = none(gear, wheel);
  for (Twist& value : out.values) value = twist;
  return out;
}

/// As many degrees of freedom as a rigid body has: unit `i`, mm or rad.
inline Twist unit_twist(int i, double size) {
  Twist twist;
  (i < 3 ? twist.d : twist.e)[i % 3] = size;
  return twist;
}

}  // namespace abbe::test
