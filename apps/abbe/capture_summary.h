#pragma once

#include <string>

#include "abbe/capture/process_map.h"
#include "abbe/capture/survey.h"

namespace abbe::app {

/// What is in a capture, for people.
[[nodiscard]] std::string summary_text(const CaptureSurvey& survey, const ProcessMap& map);
/// The same as JSON, one object.
[[nodiscard]] std::string summary_json(const CaptureSurvey& survey, const ProcessMap& map);

}  // namespace abbe::app
