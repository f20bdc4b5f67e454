#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

namespace abbe {

static_assert(std::endian::native == std::endian::little, "numbers are read from frames as they lie there");

/// A little-endian number of T's size at p.
template <class T>
[[nodiscard]] inline T load_little(const std::uint8_t* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

/// The commands of EtherCAT datagrams.
enum class EcatCommand : std::uint8_t {
  nop,
  aprd,
  apwr,
  aprw,
  fprd,
  fpwr,
  fprw,
  brd,
  bwr,
  brw,
  lrd,
  lwr,
  lrw,
  armw,
  frmw
};
inline constexpr int kEcatCommands = 15;
[[nodiscard]] std::string_view to_string(EcatCommand command);  ///< "LRW"; "?" above frmw

/// One datagram of a frame. `data` is part of the packet.
struct Datagram {
  EcatCommand command = EcatCommand::nop;
  std::uint8_t index = 0;
  std::uint32_t address = 0;  ///< logical; or position/station in the lower, register in the upper 16 bits
  std::uint16_t interrupt = 0;
  bool circulating = false;
  std::uint16_t working_counter = 0;
  std::span<const std::uint8_t> data;

  [[nodiscard]] std::uint16_t station() const { return static_cast<std::uint16_t>(address); }
  [[nodiscard]] std::uint16_t offset() const { return static_cast<std::uint16_t>(address >> 16); }
  [[nodiscard]] bool logical() const { return command >= EcatCommand::lrd && command <= EcatCommand::lrw; }
};

/// What an EtherCAT Switch Link says of a frame.
struct EslInfo {
  int port = -1;  ///< 0 to 11, -1 = none is named
  bool alignment_error = false, crc_error = false;
  std::uint64_t timestamp_ns = 0;  ///< 0 = the device gives none
};

/// What is in a packet, before its datagrams are looked at.
struct EcatFrame {
  enum class Kind {
    other,           ///< no EtherCAT
    datagrams,       ///< EtherCAT frame type 1
    other_ethercat,  ///< EtherCAT of another type (network variables, mailbox gateway)
    bad,             ///< EtherCAT, but the lengths do not fit, or (BusReader) the link says it is damaged
  } kind = Kind::other;
  std::optional<EslInfo> esl;
  int vlan_tags = 0;
  std::uint16_t vlan = 0;              ///< the identifier in the last tag
  bool udp = false;                    ///< EtherCAT in UDP
  std::uint64_t source = 0;            ///< MAC address of the sender, first byte highest
  std::span<const std::uint8_t> body;  ///< the datagrams
  std::string_view fault;              ///< kind bad: why
};

/// Splits a packet: ESL header or trailer, Ethernet, VLAN tags, UDP, EtherCAT header. Any bytes are allowed.
/// `whole` false: the recording cut the packet, so that there cannot be a trailer.
/// cost     about 3 ns; `frame` is overwritten
/// source   EtherType 0x88A4: IEC 61158-4-12; ESL: what Wireshark's dissector reads
void parse_frame(std::span<const std::uint8_t> packet, bool whole, EcatFrame& frame);
[[nodiscard]] inline EcatFrame parse_frame(std::span<const std::uint8_t> packet, bool whole = true) {
  EcatFrame frame;
  parse_frame(packet, whole, frame);
  return frame;
}

/// Walks over the datagrams of a frame.
class DatagramReader {
 public:
  explicit DatagramReader(std::span<const std::uint8_t> body)
      : p_(body.data()), end_(body.data() + body.size()) {}

  /// False behind the last datagram, and where the rest does not fit: then bad() is true.
  [[nodiscard]] bool next(Datagram& d) {
    if (!more_) return false;
    if (end_ - p_ < static_cast<std::ptrdiff_t>(kOverhead)) return stop();
    const auto word = load_little<std::uint16_t>(p_ + 6);
    const std::size_t length = word & 0x7ffU;
    if (static_cast<std::size_t>(end_ - p_) < kOverhead + length) return stop();
    d.command = static_cast<EcatCommand>(p_[0]);
    d.index = p_[1];
    d.address = load_little<std::uint32_t>(p_ + 2);
    d.circulating = (word & 0x4000U) != 0;
    d.interrupt = load_little<std::uint16_t>(p_ + 8);
    d.data = {p_ + kHeader, length};
    d.working_counter = load_little<std::uint16_t>(p_ + kHeader + length);
    more_ = (word & 0x8000U) != 0;
    p_ += kOverhead + length;
    return true;
  }
  [[nodiscard]] bool bad() const { return bad_; }

 private:
  static constexpr std::size_t kHeader = 10, kOverhead = 12;
  bool stop() {
    more_ = false;
    bad_ = true;
    return false;
  }
  const std::uint8_t *p_, *end_;
  bool more_ = true, bad_ = false;
};

}  // namespace abbe
