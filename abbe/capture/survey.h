#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/capture/bus_reader.h"
#include "abbe/capture/slave_setup.h"
#include "abbe/core/progress.h"

namespace abbe {

/// The datagrams that carry process data: one per command, logical address and length.
struct ProcessDatagram {
  EcatCommand command = EcatCommand::lrw;
  std::uint32_t address = 0;
  std::uint32_t length = 0;
  std::uint64_t sent = 0, returned = 0;             ///< frames
  std::map<std::uint16_t, std::uint64_t> counters;  ///< working counter of returning ones -> how often
  /// s: that long after the returning process datagram before it, or longer (all but 2 %); 0 = not known.
  double lead = 0;

  /// The working counter if every slave took part: the most frequent one that is not 0; 0 if there is none.
  [[nodiscard]] std::uint16_t expected() const;
};

struct BadFrame {
  std::uint64_t number = 0;
  std::string_view fault;
};

/// What is in a capture, at a glance.
struct CaptureSurvey {
  std::uint64_t packets = 0, bytes = 0;
  std::int64_t first_ns = 0, last_ns = 0;  ///< earliest and latest packet, since 1970
  std::uint64_t ethercat = 0, other = 0, other_ethercat = 0, bad = 0, cut = 0;
  std::vector<BadFrame> faults;  ///< the first kMostListed bad ones
  std::uint64_t vlan = 0, udp = 0;
  std::uint64_t esl = 0, esl_timed = 0, esl_errors = 0;
  std::array<std::uint64_t, 12> esl_ports{};
  std::array<std::uint64_t, kEcatCommands> commands{};  ///< datagrams of each command
  std::uint64_t unknown_commands = 0;
  std::uint64_t sent = 0, returned = 0,
                paired = 0;              ///< frames by their way; returned ones whose way out was seen
  std::uint64_t process_returned = 0;    ///< returning frames with process data ..
  std::uint64_t clock_returned = 0;      ///< .. and with the reference clock in the same frame
  std::vector<ProcessDatagram> process;  ///< by address
  std::optional<double> cycle;           ///< s: median time between frames of the most frequent one
  std::vector<SlaveSetup> slaves;
  std::map<std::uint16_t, int> states;
  std::uint64_t sdo_values = 0, sdo_aborts = 0;
  bool complete = true;              ///< false: stopped early, as asked
  std::optional<std::string> error;  ///< the file is broken behind the last packet counted

  static constexpr std::size_t kMostListed = 20;
};

/// The process datagram with which a bus cycle begins: the one with the longest pause before it. nullptr if
/// there are no pauses to be seen.
[[nodiscard]] const ProcessDatagram* first_of_cycle(const std::vector<ProcessDatagram>& process);

/// Reads a capture once. `most` packets at most, 0 = all.
/// errors   FileError if it cannot be opened; a damaged end is CaptureSurvey::error
/// cost     about 50 ns a frame; memory does not depend on the length
[[nodiscard]] FileResult<CaptureSurvey> survey_capture(const std::string& path, std::uint64_t most = 0,
                                                       const Progress& progress = {});

/// The reading of the distributed clock in a frame (register 0x0910, 4 or 8 bytes), ns; nullopt if there is
/// none, or one after kLatestTime.
struct ClockReading {
  std::uint64_t ns = 0;
  bool whole = false;  ///< 8 bytes; else the lower 4
};
[[nodiscard]] std::optional<ClockReading> clock_of(const BusFrame& frame);

/// The time that a switch link gives, ns; nullopt if it gives none, or one after kLatestTime.
[[nodiscard]] std::optional<std::int64_t> time_of(const EslInfo& esl);

}  // namespace abbe
