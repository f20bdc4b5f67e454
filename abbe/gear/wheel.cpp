#include "abbe/gear/wheel.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr int kMostSteps = 40;
constexpr double kSolved = 1e-12;  // mm of contact height
constexpr int kLeastChecked = 40;  // roll angles at which the profile is looked at

std::optional<WheelProblem> first_beyond(const Gear& gear, const WheelSpec& spec) {
  const double depth = gear.tip_radius - gear.root_radius;
  if (!(spec.diameter > 2 * depth && spec.diameter <= 1e4))
    return WheelProblem{WheelTrouble::value, "diameter",
                        fmt::format("the wheel's diameter is {:g} mm, not between twice the depth of the gap "
                                    "({:.3f} mm) and 10000 mm",
                                    spec.diameter, 2 * depth)};
  for (const auto& [key, value] : {std::pair{"tip_width", spec.tip_width}, std::pair{"width", spec.width}})
    if (value && !(*value > 0 && *value < 1e4))
      return WheelProblem{WheelTrouble::value, key, fmt::format("{} is {:g} mm", key, *value)};
  if (spec.swivel && !(std::abs(*spec.swivel) <= 60 * deg))
    return WheelProblem{WheelTrouble::value, "swivel",
                        fmt::format("swivel is {:g} deg, more than 60", *spec.swivel / deg)};
  return std::nullopt;
}

/// Newton on g(z) from the middle of the gap; nullopt where it does not settle.
std::optional<double> contact_height(const Gear& gear, const WheelInGap& wheel, Flank flank, double roll) {
  const Vec3 centre(wheel.centre_distance, 0, 0);
  double z = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    const FlankPoint at = flank_point(gear, flank, roll, z, Modified::profile);
    const Vec3 arm = at.position - centre;
    // g = u . (arm x n),  g' = u . (P' x n + arm x n'),  P' = kappa e_z x P + e_z,  n' = kappa e_z x n
    const Vec3 turning = gear.turn_per_mm * Vec3::UnitZ();
    const Vec3 moved = turning.cross(at.position) + Vec3::UnitZ();
    const double g = wheel.axis.dot(arm.cross(at.normal));
    const double slope = wheel.axis.dot(moved.cross(at.normal) + arm.cross(turning.cross(at.normal)));
    if (!(std::abs(slope) > 1e-9)) return std::nullopt;
    const double by = g / slope;
    z -= by;
    if (!(std::abs(z) < gear.tip_radius)) return std::nullopt;
    if (std::abs(by) < kSolved) return z;
  }
  return std::nullopt;
}

/// The width of the profile must grow and its radius shrink from the root to the tip of the gear.
bool is_single_valued(const std::vector<WheelContact>& contacts, double side_on_axis) {
  for (std::size_t i = 1; i < contacts.size(); ++i) {
    const WheelContact &a = contacts[i - 1], &b = contacts[i];
    if (!(side_on_axis * (b.axial - a.axial) > 0 && b.radius < a.radius)) return false;
  }
  return !contacts.empty() && side_on_axis * contacts.front().axial > 0;
}

std::optional<WheelProblem> fill(const Gear& gear, const std::vector<double>& rolls, WheelInGap& wheel) {
  for (const Flank flank : {Flank::right, Flank::left}) {
    std::vector<WheelContact>& contacts = wheel.contacts[flank == Flank::right ? 0 : 1];
    contacts.clear();
    for (const double roll : rolls) {
      const std::optional<WheelContact> contact = wheel_contact(gear, wheel, flank, roll);
      if (!contact)
        return WheelProblem{WheelTrouble::mesh, "diameter",
                            fmt::format("the wheel does not touch the flank at diameter {:.3f} mm",
                                        2 * gear.base_radius * std::hypot(1.0, roll))};
      contacts.push_back(*contact);
    }
  }
  return std::nullopt;
}

std::optional<WheelProblem> check_widths(WheelInGap& wheel) {
  const auto width = [&](auto at) {
    return std::abs(at(wheel.contacts[0]).axial) + std::abs(at(wheel.contacts[1]).axial);
  };
  wheel.root_width = width([](const auto& contacts) { return contacts.front(); });
  wheel.tip_width = width([](const auto& contacts) { return contacts.back(); });
  if (wheel.spec.tip_width && *wheel.spec.tip_width > wheel.root_width)
    return WheelProblem{
        WheelTrouble::larger, "tip_width",
        fmt::format("the cutter is {:.3f} mm wide at its tip, the gap {:.3f} mm where its flanks begin",
                    *wheel.spec.tip_width, wheel.root_width)};
  if (wheel.spec.width && *wheel.spec.width < wheel.tip_width)
    return WheelProblem{WheelTrouble::larger, "width",
                        fmt::format("the wheel is {:.3f} mm wide; the gap needs {:.3f} mm at the gear's tip",
                                    *wheel.spec.width, wheel.tip_width)};
  return std::nullopt;
}

}  // namespace

std::vector<double> even_rolls(const Gear& gear, int count) {
  std::vector<double> rolls;
  for (int i = 0; i < count; ++i)
    rolls.push_back(gear.form_roll + (gear.tip_roll - gear.form_roll) * i / std::max(1, count - 1));
  return rolls;
}

std::optional<WheelContact> wheel_contact(const Gear& gear, const WheelInGap& wheel, Flank flank,
                                          double roll) {
  const std::optional<double> z = contact_height(gear, wheel, flank, roll);
  if (!z) return std::nullopt;
  const FlankPoint at = flank_point(gear, flank, roll, *z, Modified::profile);
  const Vec3 arm = at.position - Vec3(wheel.centre_distance, 0, 0);
  WheelContact contact;
  contact.roll = roll;
  contact.z = *z;
  contact.position = at.position;
  contact.normal = at.normal;
  // w = u . arm,  rho = |arm - w u|
  contact.axial = wheel.axis.dot(arm);
  contact.radius = (arm - contact.axial * wheel.axis).norm();
  // f = (n . d + (arm x n) . e) / (n . t)
  contact.influence << at.normal, arm.cross(at.normal);
  contact.influence /= at.normal.dot(at.tangent);
  return contact;
}

std::variant<WheelInGap, WheelProblem> fit_wheel(const Gear& gear, const WheelSpec& spec,
                                                 const std::vector<double>& rolls) {
  if (std::optional<WheelProblem> problem = first_beyond(gear, spec)) return *problem;
  WheelInGap wheel;
  wheel.spec = spec;
  wheel.centre_distance = spec.diameter / 2 + gear.root_radius;
  const double swivel = spec.swivel.value_or(gear.spec.hand * gear.spec.helix_angle);
  // Across the helix: the tooth runs along (0, sin beta, cos beta).
  wheel.axis = Vec3(0, std::cos(swivel), -std::sin(swivel));
  const int checked = std::max(kLeastChecked, static_cast<int>(rolls.size()));
  if (std::optional<WheelProblem> problem = fill(gear, even_rolls(gear, checked), wheel)) return *problem;
  if (!is_single_valued(wheel.contacts[0], 1) || !is_single_valued(wheel.contacts[1], -1))
    return WheelProblem{
        WheelTrouble::mesh, "diameter",
        fmt::format("a wheel of {:g} mm would cut into the flank it makes: its profile turns back",
                    spec.diameter)};
  for (const auto& flank : wheel.contacts)
    for (const WheelContact& contact : flank) wheel.reach = std::max(wheel.reach, std::abs(contact.z));
  if (std::optional<WheelProblem> problem = check_widths(wheel)) return *problem;
  if (std::optional<WheelProblem> problem = fill(gear, rolls, wheel)) return *problem;
  return wheel;
}

}  // namespace abbe
