#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/gear/gear_figures.h"
#include "abbe/machine/read_machine.h"

namespace abbe {

/// How a gear is set up and cut. mm, rad, s.
struct CuttingSpec {
  double middle = 0;      ///< height of the middle of the face in the workpiece frame
  double first_gap = 0;   ///< angle of gap 1 about the workpiece's z
  double overrun = 2;     ///< the wheel's way beyond what the face needs, at both ends
  double clearance = 5;   ///< between wheel and gear on the way to the next gap
  double feed = 5;        ///< along the gap and on the way into it, mm/s
  double index_time = 2;  ///< from the end of one gap to the beginning of the way into the next
};

/// A gear file, read and checked: the gear can exist and the wheel can make it.
struct GearJob {
  std::string file;
  Gear gear;
  WheelSpec wheel;
  CuttingSpec cutting;
  EvaluationSpec evaluation;
  std::optional<int> tolerance_class;
  std::vector<int> teeth;  ///< that are shown and printed, from 1; empty: all
};

/// Reads a gear file (docs/gear-file.md): TOML, lengths in mm, angles in deg, modifications in um.
///
/// errors   every mistake with its place: those of TOML texts (E-TOML, E-FORMAT, E-UNKNOWN-KEY, E-TYPE, ..),
///          E-MISSING-KEY, E-GEAR-VALUE (a number out of its range), E-GEAR-UNDERCUT, E-GEAR-POINTED,
///          E-GEAR-GAP, E-GEAR-ORDER (impossible gears), E-GEAR-WHEEL (a wheel larger than the gap),
///          E-GEAR-MESH (a wheel that would cut into the flank it makes)
/// laws     TotalOnAnyBytes, EveryMistakeHasItsName
[[nodiscard]] Parsed<GearJob> read_gear(const MachineText& file);

}  // namespace abbe
