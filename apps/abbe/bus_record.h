#pragma once

#include <optional>
#include <string>

#include "abbe/ballbar/join_bus.h"
#include "session.h"

namespace abbe::app {

/// The columns t_s and, of both axes of the plane, X.target_position_mm and X.position_actual_mm of a CSV
/// file that `abbe capture` wrote. nullopt after telling what is missing.
[[nodiscard]] std::optional<BusRecord> load_bus_record(const std::string& file, TestPlane plane,
                                                       Session& session);

/// The test with the positions of the record, or nullopt after telling why they do not belong together.
[[nodiscard]] std::optional<BallbarTest> with_bus(BallbarTest test, const std::string& file,
                                                  Session& session);

}  // namespace abbe::app
