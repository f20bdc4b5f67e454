#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "abbe/capture/frame.h"
#include "abbe/capture/write_capture.h"
#include "abbe/core/file.h"

namespace abbe {

/// A datagram to be written: what it carries on its way out and what comes back.
struct SentDatagram {
  EcatCommand command = EcatCommand::nop;
  std::uint32_t address = 0;
  std::vector<std::uint8_t> out, back;  ///< equally long
  std::uint16_t working_counter = 0;    ///< of the returning frame
};

[[nodiscard]] inline std::uint32_t device_address(std::uint16_t station, std::uint16_t offset) {
  return std::uint32_t{offset} << 16 | station;
}

/// Writes EtherCAT frames into a classic pcap file with nanoseconds, going out and coming back.
class FrameWriter {
 public:
  FrameWriter(const CaptureSettings& settings, std::int64_t listening_since_ns, SpoolFile& out);

  /// A frame sent at that moment. Its way through the bus takes kRoundTrip.
  void exchange(std::int64_t time_ns, std::span<const SentDatagram> datagrams);
  [[nodiscard]] bool ok() const { return ok_; }

  static constexpr std::int64_t kRoundTrip = 10'000;  // ns

 private:
  void write(std::int64_t time_ns, std::span<const SentDatagram> datagrams, bool returning);
  void append_esl(std::int64_t time_ns, bool returning);

  CaptureSettings settings_;
  std::int64_t since_;
  SpoolFile& out_;
  std::string packet_;
  std::uint8_t index_ = 0;
  bool ok_ = true;
};

/// The start-up of every slave of the map, one exchange per step of `step_ns` beginning at `time_ns`: station
/// address, sync managers and FMMUs by registers, PDO assignment and mapping by CoE. Returns the count of
/// steps. Called with no writer it only counts.
std::size_t write_startup(const ProcessMap& map, std::int64_t time_ns, std::int64_t step_ns,
                          FrameWriter* writer);

}  // namespace abbe
