#pragma once

#include <optional>
#include <string>

#include "abbe/report/json_writer.h"
#include "abbe/volume/uncertainty.h"
#include "common.h"

namespace abbe::app {

struct MapUncertaintyArguments {
  bool wanted = false;
  std::size_t trials = 1000;
  std::uint64_t seed = 1;
};

void add_uncertainty_options(Command& verb, MapUncertaintyArguments& arguments);

/// How uncertain the deviations are, by [uncertainty] and [[uncertainty_mode]] of the file that states the
/// errors; nullopt after reporting why that is not known.
[[nodiscard]] std::optional<VolumeUncertainty> uncertainty_or_report(const MapUncertaintyArguments& arguments,
                                                                     const Setting& setting,
                                                                     const VolumeQuestion& question,
                                                                     const std::string& errors_file,
                                                                     Session& session);

[[nodiscard]] std::string uncertainty_text(const VolumeUncertainty& uncertainty);
/// A member "uncertainty" of the object that is open.
void write_uncertainty(JsonWriter& json, const VolumeUncertainty& uncertainty);

}  // namespace abbe::app
