#pragma once

#include <optional>
#include <string>
#include <variant>

#include "abbe/core/units.h"

namespace abbe {

/// What a drawing says of an external involute cylindrical gear. Lengths in mm, angles in rad.
struct GearSpec {
  std::string name;
  double module = 0;  ///< normal module
  int teeth = 0;
  double pressure_angle = 20 * deg;  ///< normal
  double helix_angle = 0;            ///< at the reference cylinder, not negative; 0 = spur
  int hand = 1;                      ///< +1 right-hand, -1 left-hand; of helical gears
  double profile_shift = 0;          ///< factor x of the normal module
  double face_width = 0;
  double addendum = 1, dedendum = 1.25;  ///< factors of the normal module, basic rack
  std::optional<double> tip_diameter, root_diameter;
  std::optional<double>
      form_diameter;  ///< where the involute begins; default: where a rack's tip line touches
  // Modifications: material taken off, in the transverse plane along the base tangent.
  double tip_relief = 0, tip_relief_length = 0;  ///< at the tip; roll length over which it falls to 0
  double profile_crowning = 0;                   ///< at form and tip diameter, a parabola
  double helix_crowning = 0;                     ///< at both ends of the face, a parabola
};

/// What follows from the drawing. Roll angle xi = tan(transverse pressure angle at a radius); the roll length
/// is base_radius xi.
///
///     tan alpha_t = tan alpha_n / cos beta,   d = z m_n / cos beta,   d_b = d cos alpha_t
///     d_a = d + 2 m_n (h_a + x),   d_f = d - 2 m_n (h_f - x)
///     half gap at d:   eta = pi / (2 z) - 2 x tan alpha_n / z                       theory/gears.md (3)
///     lead:            kappa = hand 2 tan beta / d   (turn about z per mm)
struct Gear {
  GearSpec spec;
  double transverse_angle = 0;  ///< alpha_t
  double base_helix_angle = 0;  ///< beta_b, not negative
  double reference_radius = 0, base_radius = 0, tip_radius = 0, root_radius = 0, form_radius = 0;
  double half_gap = 0;                                     ///< eta
  double turn_per_mm = 0;                                  ///< kappa, with the sign of the hand
  double form_roll = 0, reference_roll = 0, tip_roll = 0;  ///< xi
};

/// Why a drawing is no gear that can be cut.
enum class GearTrouble {
  value,     ///< a number out of its range
  undercut,  ///< the flank would have to begin below the base circle
  pointed,   ///< the tooth has no width left at the tip
  no_gap,    ///< the gap has no width left where the flank begins
  order,     ///< root, form and tip diameters are not in this order
};
struct GearProblem {
  GearTrouble trouble = GearTrouble::value;
  std::string key;  ///< of the gear file: "module", "form_diameter"
  std::string message;
};

/// errors   the first problem found; total: any numbers (also not finite ones) give a gear or a problem
/// laws     SeedGearHasItsPublishedNumbers, EveryImpossibleGearIsNamed
/// cost     no allocation besides the name
/// source   ISO 21771; docs/theory/gears.md, section 1
[[nodiscard]] std::variant<Gear, GearProblem> make_gear(const GearSpec& spec);

/// Roll angle at a radius not below the base radius: sqrt((r / r_b)^2 - 1).
[[nodiscard]] double roll_at(const Gear& gear, double radius);

/// inv alpha = tan alpha - alpha of the pressure angle whose tangent is `roll`.
[[nodiscard]] double involute_of_roll(double roll);

}  // namespace abbe
