#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "abbe/machine/control_setup.h"

// A tool table and a parameter file of a control: any bytes give a value or diagnostics.

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto table = abbe::read_tool_table("tool.tbl", text);
  require(table.value.has_value() != abbe::has_errors(table.diagnostics));
  if (table.value) {
    for (const auto& [number, tool] : *table.value) {
      require(number == tool.number && number >= 0);
      for (const double offset : tool.offset) require(std::isfinite(offset));
      require(!tool.gauge || *tool.gauge >= 0);
    }
  }
  const auto setup = abbe::read_parameter_file("linuxcnc.var", text);
  require(setup.value.has_value() != abbe::has_errors(setup.diagnostics));
  if (setup.value) {
    for (const auto& offset : setup.value->work_offsets) require(!offset || std::isfinite(offset->rotation));
  }
  return 0;
}
