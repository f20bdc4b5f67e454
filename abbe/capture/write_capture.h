#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "abbe/capture/process_map.h"
#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"

namespace abbe {

/// Where the frames of an EtherCAT Switch Link (ET2000, CU2508) carry port and time: 16 bytes before or
/// behind the Ethernet frame, or not at all.
enum class EslPlace { none, header, trailer };

/// How a bus that does not exist was listened to.
struct CaptureSettings {
  double cycle = 1e-3;                                ///< s between samples, 1e-6 to 1
  std::int64_t start_ns = 1'600'000'000'000'000'000;  ///< of the first cycle, since 1970, >= 10 s
  EslPlace esl = EslPlace::trailer;  ///< its timestamps are ns since the start of the listening
  bool startup = true;  ///< the traffic that sets the slaves up, so that a reader can learn the map
  bool forward = true;  ///< frames on their way out are there, too, not only the returning ones
  bool clock = true;    ///< each cycle reads the reference clock (0x0910), ns since 2000-01-01
};

/// One signal: its values in the unit of the object of that name, one per cycle.
struct CaptureColumn {
  std::string name;
  std::span<const double> values;
};

/// A classic pcap file with nanosecond timestamps, as listening between master and first slave would have
/// recorded it: optionally the start-up of every slave of the map (sync managers, FMMUs, and over CoE
/// 0x1C12/0x1C13 and 0x16xx/0x1Axx), then per cycle one LRW datagram with the process image and one FRMW of
/// the clock. Objects without a column stay 0. raw = round(value / scale), as the drive's encoder would.
///
/// map      without mistake (map_mistake), at most 1400 bytes of process data in one frame
/// columns  named after objects of the map, all of one length, values finite and inside the range of the
/// object out      a new spool file; the caller publishes it errors   E-SIMULATE what does not fit, E-FILE
/// the disk; the spool file is then to be dropped laws     read_capture gives the columns back to half a
/// count (WrittenColumnsAreReadBack) cost     about 0.2 us per cycle and 20 objects; one frame of memory
/// source   pcap: pcap-savefile(5); EtherCAT: IEC 61158-4-12, ETG.1000; ESL: the layout that Wireshark reads
[[nodiscard]] std::optional<Diagnostic> write_capture(const ProcessMap& map,
                                                      std::span<const CaptureColumn> columns,
                                                      const CaptureSettings& settings, SpoolFile& out);

}  // namespace abbe
