#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "abbe/ballbar/b5r.h"
#include "abbe/ballbar/ballbar_file.h"
#include "abbe/ballbar/diagnosis.h"

// A ball-bar trace and a .b5r file: any bytes give a value or diagnostics; a trace that is read can be
// diagnosed and written.

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto report = abbe::read_b5r("test.b5r", text);
  require(report.value.has_value() != abbe::has_errors(report.diagnostics));
  const auto trace = abbe::read_ballbar("test.csv", text, {abbe::TestPlane{}, 100.0, 10.0, 1});
  require(trace.value.has_value() != abbe::has_errors(trace.diagnostics));
  if (!trace.value || trace.value->samples() > 500) return 0;
  require(!trace.value->runs.empty());
  for (const abbe::DiagnosisTerm& term : abbe::diagnose(*trace.value).terms)
    require(std::isfinite(term.value) && std::isfinite(term.uncertainty));
  require(abbe::read_ballbar("again.csv", abbe::write_ballbar(*trace.value)).value.has_value());
  return 0;
}
