#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "abbe/capture/process_map.h"
#include "abbe/core/diagnostic.h"

namespace abbe {

/// What a map file says: which drive moves which axis, and, if it lists them, where the signals are.
struct MapFile {
  std::vector<ServoAxis> axes;
  ProcessMap map;  ///< empty: the layout comes from an ENI file or from the capture; names are not given yet
                   ///< (named())
};

/// Reads a map file (TOML):
///
///   format = 1
///   [axis.X]                      # optional
///   station = 1001                # configured address of the drive
///   counts_per_mm = 10000         # or counts_per_deg; negative if the encoder counts the other way
///   [[object]]                    # optional
///   axis = "X"                    # or station = 1001
///   index = 0x6064                # subindex = 0
///   direction = "input"           # or "output"
///   type = "int32"                # int8 .. int64, uint8 .. uint64, real32, real64, bits1 .. bits64
///   address = 0x10000             # logical address of the first byte; bit = 0 to 7
///   name = "X.position"           # optional; scale and unit likewise
///
/// errors   E-TOML and the other codes of machine files, each with its place
[[nodiscard]] Parsed<MapFile> read_map(const std::string& name, std::string_view text);

/// Reads the network information of a master (ENI, XML, ETG.2100): each slave's initial commands for FMMUs
/// and sync managers, and its PDOs. errors E-ENI
[[nodiscard]] Parsed<ProcessMap> read_eni(const std::string& name, std::string_view text);

}  // namespace abbe
