#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "abbe/capture/frame.h"
#include "abbe/capture/packet_source.h"

namespace abbe {

/// A packet of a capture and what is in it; spans are valid until the next one.
struct BusFrame {
  std::uint64_t number = 0;  ///< of the packet in the file, from 1
  Packet packet;
  EcatFrame ethernet;
  std::span<const Datagram> datagrams;  ///< of kind datagrams only, up to the first that does not fit
  bool returning = false;               ///< it has passed the slaves
  std::uint64_t partner = 0;  ///< of a returning frame: the number of the one that went out, 0 = none seen
};

/// Reads a capture frame by frame and says which way each goes.
///
/// A frame returns if a slave counted in it (a working counter is not 0), or if its sender's address has the
/// locally-administered bit that the first slave sets while the same address without it was seen before. Its
/// partner is the last frame out with the same index, commands and addresses.
class BusReader {
 public:
  [[nodiscard]] static FileResult<BusReader> open(const std::string& path);

  [[nodiscard]] bool next(BusFrame& frame);  ///< false at the end and after an error
  [[nodiscard]] const std::optional<std::string>& error() const { return source_.error(); }
  [[nodiscard]] std::uint64_t bytes() const { return source_.bytes(); }

 private:
  explicit BusReader(PacketSource source) : source_(std::move(source)) {}
  void read_datagrams(BusFrame& frame);
  void find_partner(BusFrame& frame);

  struct Sent {
    std::uint64_t number = 0, signature = 0;
  };
  PacketSource source_;
  std::vector<Datagram> datagrams_;
  std::array<Sent, 256> sent_{};                  ///< by the index of the first datagram
  std::vector<std::uint64_t> plain_;              ///< senders without the bit
  std::uint64_t last_plain_ = ~std::uint64_t{0};  ///< the last of them
  std::uint64_t number_ = 0;
};

}  // namespace abbe
