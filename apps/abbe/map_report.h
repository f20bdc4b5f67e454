#pragma once

#include <cstddef>
#include <string>

#include "abbe/volume/map.h"
#include "abbe/volume/uncertainty.h"
#include "common.h"

namespace abbe::app {

/// A finished map with everything its reports need.
struct MapAnswer {
  const Setting& setting;
  const VolumeQuestion& question;
  const VolumeMap& map;
  const VolumeUncertainty* uncertainty = nullptr;  ///< if it was asked for
  std::size_t within = 0;                          ///< points within the limits, if some are given
  bool pass = true;
};

/// The text for people. `most`: errors listed in the budget, 0 = all.
[[nodiscard]] std::string map_text(const MapAnswer& answer, std::size_t most);

/// The JSON answer (docs/command-line.md).
[[nodiscard]] std::string map_json(const MapAnswer& answer);

/// CSV: a header, then one row per point, in the order of the grid. Positions are in the units of the
/// machine file under the names of the axes, so that the file is also one for --points.
[[nodiscard]] std::string csv_header(const MapAnswer& answer);
void append_csv_row(std::string& out, const MapAnswer& answer, std::size_t point);

}  // namespace abbe::app
