#include "environment_log.h"

#include <fmt/core.h>

#include <algorithm>
#include <functional>

#include "abbe/core/file.h"
#include "abbe/evaluate/measured_table.h"
#include "abbe/signal/lag.h"
#include "common.h"

namespace abbe::app {
namespace {

constexpr double kForgotten = 3;  ///< lags after which the beginning does not count (5 %)

const MeasuredColumn* temperature(const MeasuredTable& log, std::string_view name) {
  const MeasuredColumn* found = log.find(name);
  return found != nullptr && found->quantity == Quantity::temperature ? found : nullptr;
}

}  // namespace

bool is_log_header(const std::vector<std::string>& header) {
  return std::any_of(header.begin(), header.end(),
                     [](const std::string& name) { return name.starts_with("time ["); });
}

std::vector<std::pair<std::string, double>> last_of_log(const Machine& machine, const std::string& path,
                                                        Session& session, Diagnostics& diagnostics) {
  std::vector<std::pair<std::string, double>> out;
  const FileResult<std::string> bytes = read_file(path);
  if (const auto* error = std::get_if<FileError>(&bytes)) {
    session.report(*error, path);
    return out;
  }
  Parsed<MeasuredTable> log = read_measured_table(path, std::get<std::string>(bytes));
  diagnostics.insert(diagnostics.end(), log.diagnostics.begin(), log.diagnostics.end());
  if (!log.value) return out;
  const MeasuredColumn* time = log.value->find("time");
  const bool increasing = time != nullptr && time->quantity == Quantity::time && !time->values.empty() &&
                          std::adjacent_find(time->values.begin(), time->values.end(),
                                             std::greater_equal<>()) == time->values.end();
  if (!increasing) {
    Diagnostic wrong = option_error("--environment", path + ": time does not increase", "sort the rows");
    wrong.code = "E-DRIFT-TIME";
    diagnostics.push_back(wrong);
    return out;
  }
  for (const MeasuredColumn& column : log.value->columns)
    if (column.quantity == Quantity::temperature &&
        meaning_of(machine, column.name).kind == NameMeaning::Kind::sensor)
      out.emplace_back(column.name, column.values.back());
  for (const LaggedSensor& lagged : machine.lagged_sensors) {
    const MeasuredColumn* source = temperature(*log.value, lagged.of);
    // A column of its own wins; a missing one is reported with the error that needs it.
    if (source == nullptr || temperature(*log.value, lagged.name) != nullptr) continue;
    out.emplace_back(lagged.name, first_order_lag(time->values, source->values, lagged.lag).back());
    const double duration = time->values.back() - time->values.front();
    if (duration >= kForgotten * lagged.lag) continue;
    Diagnostic warning = option_warning(
        "--environment",
        fmt::format("{} is {:.0f} s long, {} lags by {:.0f} s", path, duration, lagged.name, lagged.lag),
        "give a longer log, or begin it when the machine was in equilibrium");
    warning.code = "W-SENSOR-LOG";
    diagnostics.push_back(warning);
  }
  return out;
}

}  // namespace abbe::app
