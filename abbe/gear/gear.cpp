#include "abbe/gear/gear.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace abbe {
namespace {

constexpr double kPi = std::numbers::pi;

/// A number of the drawing and between what it must be.
struct Limit {
  const char* key;
  double value, low, high;
  const char* unit;
  double factor = 1;  ///< value = factor * number of the file
};

std::optional<GearProblem> first_beyond(const GearSpec& s) {
  const Limit limits[] = {
      {"module", s.module, 0.05, 200, "mm"},
      {"teeth", static_cast<double>(s.teeth), 5, 2000, ""},
      {"pressure_angle", s.pressure_angle, 5 * deg, 45 * deg, "deg", deg},
      {"helix_angle", s.helix_angle, 0, 45 * deg, "deg", deg},
      {"profile_shift", s.profile_shift, -5, 5, ""},
      {"face_width", s.face_width, 0.1, 5000, "mm"},
      {"addendum", s.addendum, 0.1, 3, ""},
      {"dedendum", s.dedendum, 0.1, 4, ""},
      {"tip_diameter", s.tip_diameter.value_or(1), 0.1, 1e5, "mm"},
      {"root_diameter", s.root_diameter.value_or(1), 0.1, 1e5, "mm"},
      {"form_diameter", s.form_diameter.value_or(1), 0.1, 1e5, "mm"},
      {"tip_relief", s.tip_relief, 0, 0.05 * s.module, "um", um},
      {"tip_relief_length", s.tip_relief_length, 0, 1e3, "mm"},
      {"profile_crowning", s.profile_crowning, 0, 0.05 * s.module, "um", um},
      {"helix_crowning", s.helix_crowning, 0, 0.05 * s.module, "um", um},
  };
  for (const Limit& limit : limits) {
    if (limit.value >= limit.low && limit.value <= limit.high) continue;
    return GearProblem{GearTrouble::value, limit.key,
                       fmt::format("{} is {:g}, not between {:g} and {:g}{}{}", limit.key,
                                   limit.value / limit.factor, limit.low / limit.factor,
                                   limit.high / limit.factor, *limit.unit != 0 ? " " : "", limit.unit)};
  }
  return std::nullopt;
}

void set_diameters(Gear& gear) {
  const GearSpec& s = gear.spec;
  const double cos_beta = std::cos(s.helix_angle);
  // tan alpha_t = tan alpha_n / cos beta
  gear.transverse_angle = std::atan(std::tan(s.pressure_angle) / cos_beta);
  // tan beta_b = tan beta cos alpha_t
  gear.base_helix_angle = std::atan(std::tan(s.helix_angle) * std::cos(gear.transverse_angle));
  // r = z m_n / (2 cos beta)
  gear.reference_radius = 0.5 * s.teeth * s.module / cos_beta;
  gear.base_radius = gear.reference_radius * std::cos(gear.transverse_angle);
  const double x = s.profile_shift;
  gear.tip_radius =
      s.tip_diameter ? *s.tip_diameter / 2 : gear.reference_radius + s.module * (s.addendum + x);
  gear.root_radius =
      s.root_diameter ? *s.root_diameter / 2 : gear.reference_radius - s.module * (s.dedendum - x);
  // eta = pi / (2 z) - 2 x tan alpha_n / z
  gear.half_gap = (kPi / 2 - 2 * x * std::tan(s.pressure_angle)) / s.teeth;
  gear.turn_per_mm = s.hand * std::tan(s.helix_angle) / gear.reference_radius;
  gear.reference_roll = std::tan(gear.transverse_angle);
}

/// Half the angle of the gap at a roll angle.
double half_gap_at(const Gear& gear, double roll) {
  return gear.half_gap + involute_of_roll(roll) - involute_of_roll(gear.reference_roll);
}

/// Where the flank begins: as stated, or where the tip line of a rack touches it.
std::optional<GearProblem> set_form(Gear& gear) {
  const GearSpec& s = gear.spec;
  if (s.form_diameter) {
    gear.form_radius = *s.form_diameter / 2;
    if (gear.form_radius < gear.base_radius)
      return GearProblem{GearTrouble::undercut, "form_diameter",
                         fmt::format("the involute begins at the base diameter {:.4f} mm, not at {:.4f} mm",
                                     2 * gear.base_radius, 2 * gear.form_radius)};
    gear.form_roll = roll_at(gear, gear.form_radius);
    return std::nullopt;
  }
  // L_form = r_b tan alpha_t - m_n (h_a - x) / sin alpha_t
  const double length = gear.base_radius * gear.reference_roll -
                        s.module * (s.addendum - s.profile_shift) / std::sin(gear.transverse_angle);
  if (length < 0)
    return GearProblem{GearTrouble::undercut, "teeth",
                       fmt::format("{} teeth with profile shift {:g} are undercut: the flank that a rack "
                                   "needs begins {:.3f} mm of roll below the base circle",
                                   s.teeth, s.profile_shift, -length)};
  gear.form_roll = length / gear.base_radius;
  gear.form_radius = gear.base_radius * std::hypot(1.0, gear.form_roll);
  if (gear.form_radius < gear.root_radius) {
    gear.form_radius = gear.root_radius;
    gear.form_roll = roll_at(gear, gear.root_radius);
  }
  return std::nullopt;
}

}  // namespace

double roll_at(const Gear& gear, double radius) {
  // xi = sqrt((r / r_b)^2 - 1)
  const double ratio = radius / gear.base_radius;
  return ratio > 1 ? std::sqrt((ratio - 1) * (ratio + 1)) : 0.0;
}

double involute_of_roll(double roll) { return roll - std::atan(roll); }

std::variant<Gear, GearProblem> make_gear(const GearSpec& spec) {
  if (std::optional<GearProblem> problem = first_beyond(spec)) return *problem;
  Gear gear;
  gear.spec = spec;
  gear.spec.hand = spec.hand < 0 ? -1 : 1;
  set_diameters(gear);
  if (std::optional<GearProblem> problem = set_form(gear)) return *problem;
  gear.tip_roll = roll_at(gear, gear.tip_radius);
  const bool ordered = gear.root_radius > 0 && gear.root_radius <= gear.form_radius &&
                       gear.form_roll < gear.reference_roll && gear.reference_roll < gear.tip_roll;
  if (!ordered)
    return GearProblem{
        GearTrouble::order, "tip_diameter",
        fmt::format("diameters of root {:.4f}, form {:.4f}, reference {:.4f} and tip {:.4f} mm do "
                    "not follow each other",
                    2 * gear.root_radius, 2 * gear.form_radius, 2 * gear.reference_radius,
                    2 * gear.tip_radius)};
  // The tooth at the tip: pi / z less half the gap.
  const double tooth = kPi / spec.teeth - half_gap_at(gear, gear.tip_roll);
  if (!(tooth > 0))
    return GearProblem{GearTrouble::pointed, "tip_diameter",
                       fmt::format("the flanks of a tooth cross {:.3f} mm below the tip diameter",
                                   -tooth * gear.tip_radius / gear.tip_roll)};
  if (const double gap = half_gap_at(gear, gear.form_roll); !(gap > 0))
    return GearProblem{
        GearTrouble::no_gap, "form_diameter",
        fmt::format("the gap is {:.3f} mm wide where the flanks begin", 2 * gap * gear.form_radius)};
  if (spec.tip_relief > 0 && !(spec.tip_relief_length > 0 &&
                               spec.tip_relief_length < gear.base_radius * (gear.tip_roll - gear.form_roll)))
    return GearProblem{
        GearTrouble::value, "tip_relief_length",
        "tip relief needs the roll length over which it falls to 0, less than that of the flank"};
  return gear;
}

}  // namespace abbe
