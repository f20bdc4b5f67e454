#pragma once

#include <cstdint>
#include <vector>

#include "abbe/capture/process_map.h"

namespace abbe {

/// The part of the process image that one slave reads or writes.
struct SlaveRange {
  std::uint16_t station = 0;
  PdoDirection direction = PdoDirection::input;
  std::uint64_t begin = 0, end = 0;       ///< logical bits, [begin, end)
  std::vector<const PdoObject*> objects;  ///< of the map, by rising address

  /// Bytes of the logical address range, partly covered ones included.
  [[nodiscard]] std::uint32_t first_byte() const { return static_cast<std::uint32_t>(begin / 8); }
  [[nodiscard]] std::uint16_t bytes() const { return static_cast<std::uint16_t>((end + 7) / 8 - begin / 8); }
};

/// The ranges of a map, by station, outputs before inputs.
[[nodiscard]] std::vector<SlaveRange> slave_ranges(const ProcessMap& map);

/// False if no PDO mapping can say this layout: a PDO in two pieces, or of more than 254 entries.
[[nodiscard]] bool can_be_mapped(const SlaveRange& range);

}  // namespace abbe
