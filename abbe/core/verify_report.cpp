#include "abbe/core/verify_report.h"

#include <algorithm>

namespace abbe {

void note_datum(std::vector<DatumShift>& datums, const DatumShift& shift) {
  const bool known = std::any_of(datums.begin(), datums.end(), [&](const DatumShift& other) {
    return other.frame == shift.frame && other.tool == shift.tool && other.removed == shift.removed;
  });
  if (!known && datums.size() < kMostDatums) datums.push_back(shift);
}

}  // namespace abbe
