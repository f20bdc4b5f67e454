#include "abbe/surface/read_surface.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "abbe/surface/nearest.h"

// Surface files: any bytes give a surface or diagnostics; a surface that is read has numbers everywhere.

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const abbe::Parsed<abbe::NurbsSurface> read = abbe::read_surface(text, "part.toml");
  if (read.value.has_value() == abbe::has_errors(read.diagnostics)) std::abort();
  if (!read.value) return 0;
  if (!read.value->is_valid()) std::abort();
  const abbe::NearestPoint nearest(*read.value);
  const abbe::SurfaceFoot foot = nearest(abbe::Vec3(1, 2, 3));
  const abbe::Curvature bend = abbe::curvature_at(foot.at);
  if (!foot.at.p.allFinite() || !(bend.least <= bend.most)) std::abort();
  return 0;
}
