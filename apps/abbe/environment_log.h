#pragma once

#include <string>
#include <utility>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/machine/machine.h"
#include "session.h"

namespace abbe::app {

/// True for the header of a log in time: a column `time [s]`, `[min]` or `[h]`.
[[nodiscard]] bool is_log_header(const std::vector<std::string>& header);

/// The temperatures in the last row of a log (a table of measured numbers) that the machine's errors depend
/// on, and what its lagged sensors are then (first_order_lag from the first row on). Mistakes gather in
/// `diagnostics`; so does the warning that a log is shorter than three lags.
[[nodiscard]] std::vector<std::pair<std::string, double>> last_of_log(const Machine& machine,
                                                                      const std::string& path,
                                                                      Session& session,
                                                                      Diagnostics& diagnostics);

}  // namespace abbe::app
