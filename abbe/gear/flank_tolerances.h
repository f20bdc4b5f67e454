#pragma once

#include <optional>

#include "abbe/gear/gear.h"

namespace abbe {

/// Flank tolerances of ISO 1328-1:2013, unrounded, mm. Slopes are allowed to both signs.
struct FlankTolerances {
  double f_p = 0, F_p = 0;                           ///< single and total cumulative pitch
  double f_H_alpha = 0, f_f_alpha = 0, F_alpha = 0;  ///< profile slope, form, total
  double f_H_beta = 0, f_f_beta = 0, F_beta = 0;     ///< helix slope, form, total
  double F_r = 0;                                    ///< runout, informative
};

/// With g = sqrt(2)^(A - 5), d, m_n, b in mm, results in um:
///
///     f_pT  = (0.001 d + 0.4 m_n + 5) g                 f_HaT = (0.4 m_n + 0.001 d + 4) g
///     F_pT  = (0.002 d + 0.55 sqrt d + 0.7 m_n + 12) g  f_faT = (0.55 m_n + 5) g
///     f_HbT = (0.05 sqrt d + 0.35 sqrt b + 4) g         f_fbT = (0.07 sqrt d + 0.45 sqrt b + 4) g
///     F_aT  = sqrt(f_HaT^2 + f_faT^2),  F_bT = sqrt(f_HbT^2 + f_fbT^2),  F_rT = 0.9 F_pT
///
/// errors   nullopt: outside the standard's range, where it allows no extrapolation: class 1 to 11, 5 to 1000
///          teeth, d 5 to 15000 mm, m_n 0.5 to 70 mm, b 4 to 1200 mm, helix angle up to 45 deg
/// laws     SeedGearHasItsTolerances, AClassIsARootOfTwo
/// source   ISO 1328-1:2013, (5) to (12)
[[nodiscard]] std::optional<FlankTolerances> flank_tolerances(const Gear& gear, int tolerance_class);

/// A tolerance as the standard prints it (5.2.3), mm: above 10 um whole, 5 to 10 um halves, below 5 um tenths
/// of a micrometre.
[[nodiscard]] double rounded_tolerance(double tolerance);

/// The best class whose rounded tolerance is not below `deviation` (mm, a range or a magnitude); nullopt:
/// beyond class 11, or outside the standard's range.
[[nodiscard]] std::optional<int> class_of(const Gear& gear, double FlankTolerances::*which, double deviation);

}  // namespace abbe
