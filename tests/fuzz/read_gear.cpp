#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "abbe/gear/gear_file.h"

// Gear files: any bytes give a gear or diagnostics; the flanks and the wheel of a gear that is read are
// numbers.

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const abbe::Parsed<abbe::GearJob> job = abbe::read_gear({"gear.toml", text});
  require(job.value.has_value() != abbe::has_errors(job.diagnostics));
  if (!job.value) return 0;
  const abbe::Gear& gear = job.value->gear;
  const auto rolls = abbe::even_rolls(gear, 3);
  for (const abbe::Flank flank : {abbe::Flank::right, abbe::Flank::left})
    for (const double roll : rolls) {
      const abbe::FlankPoint at =
          abbe::flank_point(gear, flank, roll, gear.spec.face_width / 2, abbe::Modified::all);
      require(at.position.allFinite() && std::abs(at.normal.norm() - 1) < 1e-9);
    }
  const auto wheel = abbe::fit_wheel(gear, job.value->wheel, rolls);
  require(std::holds_alternative<abbe::WheelInGap>(wheel));
  return 0;
}
