#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/capture/process_map.h"
#include "abbe/capture/survey.h"
#include "command_line.h"
#include "session.h"

namespace abbe::app {

/// What the map of a capture without --map and --eni comes from.
inline constexpr const char* kLearned = "start-up traffic";

/// Options that say where the signals are in the frames.
struct MapArguments {
  std::string map, eni;
  std::vector<std::string> axes;
};
void add_map_options(Command& verb, MapArguments& arguments);

/// Axes and layout as the options give them; `layout` empty if they do not. nullopt after reporting mistakes.
struct GivenMap {
  std::vector<ServoAxis> axes;
  std::optional<ProcessMap> layout;
};
[[nodiscard]] std::optional<GivenMap> load_map(const MapArguments& arguments, Session& session);

/// What the start-up traffic says; empty where none was recorded.
[[nodiscard]] ProcessMap learned_map(const CaptureSurvey& survey, Diagnostics& findings);

/// The given layout, else the one the capture's start-up traffic says, with names and units. nullopt after
/// E-CAPTURE-MAP.
[[nodiscard]] std::optional<ProcessMap> map_for(const GivenMap& given, const CaptureSurvey& survey,
                                                const std::string& file, Session& session);

}  // namespace abbe::app
