#pragma once

#include <string>
#include <variant>
#include <vector>

#include "abbe/gear/machine_cut.h"
#include "abbe/gear/pose_map.h"

namespace abbe {

/// A figure over all teeth: its mean, with sign, and how much it differs from tooth to tooth.
struct TeethFigure {
  double mean = 0, range = 0;  ///< mm
};

/// What one error does to a gear.
struct GearEffects {
  std::array<TeethFigure, 2> profile_slope, helix_slope;  ///< f_H_alpha, f_H_beta: right, left
  double profile_form = 0, helix_form = 0;                ///< largest f_f_alpha, f_f_beta
  double f_p = 0, F_p = 0, F_r = 0;                       ///< of the worse side
  double depth = 0;                                       ///< mean radial position of a ball in the gaps
};
/// The effects beyond what the process itself leaves (crowning), `process`.
[[nodiscard]] GearEffects effects_of(const GearFigures& figures, const GearFigures& process);

struct SensitivityRow {
  std::string name;
  bool rotation = false;
  GearEffects effects;
};

/// One unit of each: of which error the gear knows, and by which figure. Units: `length` mm, `angle` rad.
struct SensitivityUnits {
  double length = 0.010, angle = 10e-6;
};

/// Of the 24 deviations of gear and wheel, by themselves, without a machine.
/// laws   RowsAreTheClosedForms
[[nodiscard]] std::vector<SensitivityRow> pose_sensitivity(const GearJob& job, const WheelInGap& wheel,
                                                           const GearInspection& inspection,
                                                           const SensitivityUnits& units);

/// Of one unit of every error that the chain can have (components and location errors of all axes, mounting
/// of tool and work), in the first-order model.
/// cost   one cut per error
[[nodiscard]] std::vector<SensitivityRow> machine_sensitivity(
    const Machine& machine, const GearJob& job, const WheelInGap& wheel, const CuttingMotion& motion,
    const GearInspection& inspection, const SensitivityUnits& units, const Progress& progress = {});

/// Of every error of the machine file by itself, as it is given: a budget. Uses model, environment and course
/// of `options`.
[[nodiscard]] std::vector<SensitivityRow> error_budget(const Machine& machine, const GearJob& job,
                                                       const WheelInGap& wheel, const CuttingMotion& motion,
                                                       const GearInspection& inspection,
                                                       const CutOptions& options,
                                                       const Progress& progress = {});

}  // namespace abbe
