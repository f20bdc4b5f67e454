#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/volume/map.h"
#include "common.h"

namespace abbe::app {

/// The options that say which volume is looked at, as typed.
struct VolumeArguments {
  std::vector<std::string> range, positions, at, count, datum;
  unsigned threads = 0;
};

void add_volume_options(Command& verb, VolumeArguments& arguments);

/// The grid and its circumstances; nullopt after reporting everything that is wrong with the options.
[[nodiscard]] std::optional<VolumeQuestion> read_volume(const VolumeArguments& arguments,
                                                        const Setting& setting, Session& session);

/// Axes of the grid that go beyond their travel, by name.
[[nodiscard]] std::vector<std::string> outside_travel(const Machine& machine, const VolumeGrid& grid);

}  // namespace abbe::app
