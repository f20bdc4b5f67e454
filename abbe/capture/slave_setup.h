#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "abbe/capture/process_map.h"
#include "abbe/core/diagnostic.h"

namespace abbe {

/// An entry of a PDO: an object, or padding (index 0).
struct PdoEntry {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  int bits = 0;
  std::optional<PdoType> type;  ///< if the source says it
};

/// What a master set up in a slave, as far as it was seen.
struct SlaveSetup {
  std::uint16_t station = 0;
  std::string name;                                     ///< may be empty
  std::array<std::uint8_t, 256> fmmu{};                 ///< registers 0x0600 to 0x06FF
  std::array<std::uint8_t, 128> sync_manager{};         ///< registers 0x0800 to 0x087F
  std::map<int, std::vector<std::uint16_t>> assigned;   ///< PDOs of a sync manager, in order
  std::map<std::uint16_t, std::vector<PdoEntry>> pdos;  ///< 0x1600.. and 0x1A00..
};

inline constexpr std::uint16_t kFmmuRegisters = 0x0600, kSyncManagerRegisters = 0x0800;

/// Puts bytes written to a register of the slave where they belong; other registers change nothing.
void set_registers(SlaveSetup& slave, std::uint16_t offset, std::span<const std::uint8_t> bytes);

/// Sync manager k as its 8 registers say.
struct SyncManagerState {
  std::uint16_t start = 0, length = 0;
  bool mailbox = false;
};
[[nodiscard]] SyncManagerState sync_manager_of(const SlaveSetup& slave, int k);

/// Where every object is in the logical process image: FMMUs say which bytes of a slave's memory appear
/// where, sync managers which of those bytes are inputs or outputs, PDOs what the bits of those bytes mean.
///
///   bit(object) = 8 logical + start bit + position in the PDOs - 8 (physical - sync manager start) -
///   physical bit
///
/// A range whose PDOs are not known becomes objects without index, at most 32 bits each. Columns are not
/// named yet: see named(). W-CAPTURE-MAP for an object that an FMMU maps only in part, and where
/// there are more than 65536 (nonsense in the registers).
[[nodiscard]] ProcessMap map_of(std::span<const SlaveSetup> slaves, Diagnostics& findings);

}  // namespace abbe
