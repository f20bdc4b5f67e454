#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "abbe/evaluate/drift.h"
#include "abbe/evaluate/positioning.h"
#include "abbe/evaluate/run_table.h"

// Files of measurements: any bytes give finite numbers or diagnostics.

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto runs = abbe::read_runs("runs.csv", text);
  require(runs.value.has_value() != abbe::has_errors(runs.diagnostics));
  if (runs.value) {
    const abbe::PositioningFigures figures = abbe::positioning_figures(*runs.value);
    require(std::isfinite(figures.A.both) && figures.E.both >= 0);
  }
  const auto table = abbe::read_measured_table("log.csv", text);
  require(table.value.has_value() != abbe::has_errors(table.diagnostics));
  if (table.value) {
    const auto drift = abbe::drift_figures(*table.value);
    require(drift.value.has_value() != abbe::has_errors(drift.diagnostics));
  }
  return 0;
}
