// Any bytes as a profile of a control: a value, or reasons with places.

#include "abbe/machine/read_profile.h"

#include <cstdint>
#include <cstdlib>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto parsed = abbe::read_profile("fuzz.toml", {reinterpret_cast<const char*>(data), size});
  if (parsed.value.has_value() == abbe::has_errors(parsed.diagnostics)) std::abort();
  return 0;
}
