#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "abbe/core/linear_algebra.h"

namespace abbe::oracle {

/// One motion as LinuxCNC's interpreter hands it to the machine: positions of the controlled point in
/// machine coordinates, mm.
struct Motion {
  enum class Kind { rapid, feed, arc } kind = Kind::rapid;
  long line = 0;  ///< of the program, from 1
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();
  int tool = -1;  ///< in the spindle; -1: none was loaded by the program

  // Arcs only.
  Vec3 centre = Vec3::Zero();   ///< at the height of the end
  Vec3 normal = Vec3::UnitZ();  ///< turning is right-handed about it for turns > 0
  int turns = 0;                ///< +1: up to one full turn, +2: one more, negative: clockwise
};

/// The point at fraction s of a motion: lines straight, arcs with radius and height linear in the angle.
[[nodiscard]] Vec3 point_at(const Motion& motion, double s);

struct Run {
  bool accepted = false;  ///< ran to the end of the program
  bool open_end = false;  ///< every line ran, only M2, M30 or % is missing
  std::string message;    ///< why not accepted
  std::vector<Motion> motions;
};

/// Runs a program from machine position 0 with all work offsets 0. nullopt: the oracle did not start.
[[nodiscard]] std::optional<Run> run(const std::string& oracle, const std::string& tool_table,
                                     const std::string& program, const std::string& scratch);

}  // namespace abbe::oracle
