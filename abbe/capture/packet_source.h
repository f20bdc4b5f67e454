#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "abbe/core/file.h"

namespace abbe {

/// One recorded packet. `bytes` is valid until the next packet is asked for.
struct Packet {
  std::span<const std::uint8_t> bytes;
  std::uint32_t original = 0;  ///< length on the wire; more than bytes.size() if the recording cut it
  std::int64_t time_ns = 0;    ///< since 1970, as the recorder wrote it
};

/// Reads the packets of a capture file one after the other, in memory that does not depend on its length.
/// Classic pcap files of Ethernet are read in large pieces here; everything else that libpcap knows (pcapng
/// ..) is read by libpcap, with nanoseconds.
///
/// errors   not a capture; another link type than Ethernet; a file that ends inside a packet or has
///          nonsense lengths or times (before 1970, after kLatestTime): the packets before are given, then
///          error() says so
/// cost     classic pcap 20 ns, libpcap 80 ns a packet
class PacketSource {
 public:
  [[nodiscard]] static FileResult<PacketSource> open(const std::string& path);
  ~PacketSource();
  PacketSource(PacketSource&&) noexcept;
  PacketSource& operator=(PacketSource&&) noexcept;

  [[nodiscard]] bool next(Packet& packet);  ///< false at the end and after an error
  [[nodiscard]] const std::optional<std::string>& error() const;
  [[nodiscard]] std::uint64_t packets() const;  ///< given so far
  [[nodiscard]] std::uint64_t bytes() const;    ///< of those packets, for progress

 private:
  PacketSource();
  struct State;
  std::unique_ptr<State> state_;
};

/// The latest time that is believed, ns since 1970 (the year 2116) or since any other epoch: differences of
/// times fit into 64 bits.
inline constexpr std::int64_t kLatestTime = std::int64_t{1} << 62;
/// The largest packet that is believed; a larger length means that the file is damaged.
inline constexpr std::uint32_t kMostPacket = 1U << 18;

}  // namespace abbe
