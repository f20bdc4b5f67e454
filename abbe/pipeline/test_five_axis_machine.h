#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "abbe/chain/control_kinematics.h"
#include "abbe/chain/plan.h"
#include "abbe/core/units.h"
#include "abbe/pipeline/test_random_machine.h"

/// Five-axis machines of every structure with errors drawn at random, as machine files.
namespace abbe::testing {

inline constexpr double kToolLength = 120;

struct Structure {
  const char* chain;
  char tilt, turn;  ///< the axis that tilts the tool against the work, and the other one
};
inline constexpr Structure kStructures[] = {{"w C A b Y X Z t", 'A', 'C'}, {"w C B b X Y Z t", 'B', 'C'},
                                            {"w b X Y Z C B t", 'B', 'C'}, {"w b X Y Z C A t", 'A', 'C'},
                                            {"w C b X Y Z B t", 'B', 'C'}, {"w C X b Y Z B t", 'B', 'C'},
                                            {"w A b X Y Z B t", 'B', 'A'}};

/// Errors of every axis as polynomials and sines; location errors of the rotary axes.
inline std::string machine_text(Random& random, const Structure& structure, const std::string& control,
                                double scale = 1) {
  const std::string chain = structure.chain;
  std::string text = fmt::format("format = 1\n[machine]\nname = \"five axes\"\nchain = \"{}\"\n", chain);
  const std::size_t bed = chain.find('b');
  std::string errors;
  const auto size = [&](double s) { return scale * random.between(-s, s); };
  for (const char axis : {'X', 'Y', 'Z', 'A', 'B', 'C'}) {
    const std::size_t at = chain.find(axis);
    if (at == std::string::npos) continue;
    const bool rotary = axis <= 'C';
    text += fmt::format("[axis.{}]\n", axis);
    text += rotary ? fmt::format("direction = [{}, {}, {}]\norigin = [{:.2f}, {:.2f}, {:.2f}]\n",
                                 axis == 'A' ? 1 : 0, axis == 'B' ? 1 : 0, axis == 'C' ? 1 : 0,
                                 random.between(-20, 20), random.between(-20, 20), random.between(-150, 150))
                   : "range = [-1500, 1500]\n";
    if (at < bed) text += "errors_seen = \"body\"\n";
    for (const char direction : {'X', 'Y', 'Z', 'A', 'B', 'C'}) {
      if (random.chance(0.3)) continue;
      if (rotary) {
        errors += fmt::format("E{}{} = {{ sine = [{:.4f}, {:.9f}, {:.4f}] }}\n", direction, axis,
                              size(direction >= 'X' ? 6 : 15), deg, random.between(-3, 3));
      } else {
        errors += fmt::format("E{}{} = {{ poly = [0, {:.6f}, {:.9f}] }}\n", direction, axis, size(0.04),
                              size(4e-5));
      }
    }
  }
  for (const char axis : {structure.tilt, structure.turn}) {
    for (const char direction : {'X', 'Y', 'Z', 'A', 'B', 'C'}) {
      if (direction == axis || direction == axis - 'A' + 'X') continue;
      errors += fmt::format("E{}0{} = {:.3f}\n", direction, axis, size(30));
    }
  }
  text += fmt::format("[tool]\norigin = [0, 0, 100]\nlength = {}\n", kToolLength);
  return text + control + "[errors]\n" + errors;
}

/// Rotary positions of 0.001 deg, and the tool's direction there in workpiece axes.
struct DrawnStance {
  double tilt = 0, turn = 0;  ///< deg
  Vec3 direction = Vec3::UnitZ();
};
inline DrawnStance draw_stance(Random& random, const Structure& structure, const Plan& plan) {
  const auto rounded = [](double value) { return std::round(value / 0.001) * 0.001; };
  DrawnStance stance;
  stance.tilt = rounded(random.between(-60, 60));
  stance.turn = rounded(random.between(-170, 170));
  Turns turns{};
  turns[static_cast<std::size_t>(structure.tilt - 'A')] = stance.tilt * deg;
  turns[static_cast<std::size_t>(structure.turn - 'A')] = stance.turn * deg;
  const ControlKinematics kinematics(plan.machine(), addressed_axes(plan.machine()));
  stance.direction = kinematics.pose(Vec3::Zero(), turns, tool_of(plan.machine())).tool_axis;
  return stance;
}

}  // namespace abbe::testing
