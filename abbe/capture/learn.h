#pragma once

#include <cstdint>
#include <map>

#include "abbe/capture/coe.h"
#include "abbe/capture/frame.h"
#include "abbe/capture/slave_setup.h"

namespace abbe {

/// Learns from a bus how its master set up the slaves: registers written by station address, and the objects
/// 0x1C10 to 0x1C2F (assignment), 0x1600 to 0x17FF and 0x1A00 to 0x1BFF (mapping) written or read over CoE.
/// Only what slaves confirmed (working counter not 0) counts.
class SetupListener {
 public:
  /// A datagram of a returning frame.
  void hear(const Datagram& datagram);

  /// By station. Registers that were never seen are 0.
  [[nodiscard]] std::vector<SlaveSetup> slaves() const;
  [[nodiscard]] std::uint64_t sdo_values() const { return values_; }
  [[nodiscard]] std::uint64_t sdo_aborts() const { return sdo_.aborted(); }
  /// Application-layer state last read from 0x0130: 1 INIT, 2 PREOP, 3 BOOT, 4 SAFEOP, 8 OP.
  [[nodiscard]] const std::map<std::uint16_t, int>& states() const { return states_; }

 private:
  void take(const SdoValue& value);
  std::map<std::uint16_t, SlaveSetup> slaves_;
  std::map<std::uint16_t, int> states_;
  SdoListener sdo_;
  std::uint64_t values_ = 0;
};

}  // namespace abbe
