#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "abbe/gear/flank.h"

namespace abbe {

/// A disc cutter or grinding wheel whose axial profile fills the gap. mm, rad.
struct WheelSpec {
  double diameter = 0;
  std::optional<double>
      tip_width;  ///< of a cutter that exists: flat at its tip; default: as wide as the gap allows
  std::optional<double> width;   ///< of its body; default: as wide as the profile needs
  std::optional<double> swivel;  ///< of the wheel axis about x; default: the helix angle
};

/// Six numbers (d, e): displacement and small rotation.
using Vec6 = Eigen::Matrix<double, 6, 1>;

/// Where the wheel touches the flank at one roll angle while its centre is at height 0 of its gap.
struct WheelContact {
  double roll = 0;
  double z = 0;  ///< height of the contact above the wheel's centre: at height t it is made at t + z
  Vec3 position = Vec3::Zero(), normal = Vec3::Zero();  ///< of the flank, frame of the gap
  double axial = 0, radius = 0;                         ///< of the wheel's profile at that place
  /// Deviation of the flank (transverse, + = excess material) per unit of displacement d of the wheel and of
  /// its rotation e about its centre, frame of the gap:   f = (n . d + ((P - A) x n) . e) / (n . t)
  Vec6 influence = Vec6::Zero();
};

/// A wheel in its gap: all that is the same in every gap and at every height.
struct WheelInGap {
  WheelSpec spec;
  double centre_distance = 0;  ///< of wheel and gear axes: wheel radius + root radius
  Vec3 axis = Vec3::UnitY();   ///< unit vector of the wheel axis, frame of the gap at the wheel's height
  double reach = 0;            ///< largest height difference of contact and wheel centre
  double root_width = 0, tip_width = 0;  ///< of the profile where the flank begins and at the gear's tip
  std::array<std::vector<WheelContact>, 2> contacts;  ///< per flank, one per roll angle asked for

  [[nodiscard]] const std::vector<WheelContact>& of(Flank flank) const {
    return contacts[flank == Flank::right ? 0 : 1];
  }
};

/// Why a wheel cannot make the gap.
enum class WheelTrouble {
  value,   ///< a number out of its range
  larger,  ///< wider than the gap, or narrower than its profile
  mesh,    ///< no wheel of this diameter and swivel touches the whole flank: it would cut into it
};
struct WheelProblem {
  WheelTrouble trouble = WheelTrouble::value;
  std::string key;
  std::string message;
};

/// The wheel touches the flank where the normal meets the wheel axis (through A = (a, 0, 0), along u):
///
///     g(z) = u . ((P(xi, z) - A) x n(xi, z)) = 0                                     theory/gears.md (6)
///     profile:   w = u . (P - A),   rho = |P - A - w u|
///
/// solved by Newton for every roll angle, on the flank with its profile modifications and without crowning
/// along the face, which is a motion.
///
/// rolls    increasing, from the form to the tip roll; the form and the tip are always looked at
/// errors   a WheelProblem; a profile that is not single-valued (|w| or rho not monotonic) is `mesh`, and so
///          is a body of the wheel that reaches into a tooth anywhere around its axis
/// laws     SpurContactIsThePlaneOfTheWheel, NormalsMeetTheAxis, AWheelCutsWhatItWasMadeFor,
///          TurningAboutItsAxisDoesNothing
/// cost     a few flank points per roll angle
/// source   Litvin, Fuentes: Gear Geometry and Applied Theory, 2nd ed., 24.3; docs/theory/gears.md, section 2
[[nodiscard]] std::variant<WheelInGap, WheelProblem> fit_wheel(const Gear& gear, const WheelSpec& spec,
                                                               const std::vector<double>& rolls);

/// `count` roll angles evenly from the form to the tip, and so the roll lengths.
[[nodiscard]] std::vector<double> even_rolls(const Gear& gear, int count);

/// The contact at any roll angle; nullopt: none (fit_wheel says why).
[[nodiscard]] std::optional<WheelContact> wheel_contact(const Gear& gear, const WheelInGap& wheel,
                                                        Flank flank, double roll);

}  // namespace abbe
