#include "abbe/capture/frame.h"

#include <algorithm>
#include <array>

namespace abbe {
namespace {

constexpr std::uint16_t kEthercat = 0x88a4, kIpv4 = 0x0800;
constexpr std::uint16_t kEthercatPort = 0x88a4;
constexpr std::uint8_t kUdp = 17;
constexpr std::size_t kEslSize = 16, kMacs = 12;

std::uint16_t load_big16(const std::uint8_t* p) { return static_cast<std::uint16_t>(p[0] << 8 | p[1]); }

// 01 01 05 10 00 00, or 11 in the fourth place.
bool is_esl(const std::uint8_t* p) {
  const auto first = load_little<std::uint32_t>(p);
  return (first == 0x10050101U || first == 0x11050101U) && load_little<std::uint16_t>(p + 4) == 0;
}

EslInfo read_esl(const std::uint8_t* p) {
  // Bits 7 to 0 are ports 0 to 7, then: 8 extended, 9 port 11, 10 port 10, 11 alignment error, 12 CRC error,
  // 13 timestamp valid, 14 port 9, 15 port 8. The lowest port that is named counts.
  constexpr std::array<int, 12> kBitOfPort = {7, 6, 5, 4, 3, 2, 1, 0, 15, 14, 10, 9};
  const auto flags = load_little<std::uint16_t>(p + 6);
  EslInfo info;
  for (std::size_t port = 0; port < kBitOfPort.size() && info.port < 0; ++port) {
    if ((flags >> kBitOfPort[port] & 1) != 0) info.port = static_cast<int>(port);
  }
  info.alignment_error = (flags & 0x0800) != 0;
  info.crc_error = (flags & 0x1000) != 0;
  info.timestamp_ns = load_little<std::uint64_t>(p + 8);
  return info;
}

bool is_vlan_tag(std::uint16_t type) { return type == 0x8100 || type == 0x88a8 || type == 0x9100; }

/// The payload of a UDP packet to the EtherCAT port; empty for any other IPv4 packet.
std::span<const std::uint8_t> udp_payload(std::span<const std::uint8_t> ip) {
  constexpr std::size_t kLeastHeader = 20, kUdpHeader = 8;
  if (ip.size() < kLeastHeader) return {};
  const std::size_t header = std::size_t{ip[0] & 0x0fU} * 4;
  if (ip[0] >> 4 != 4 || header < kLeastHeader || ip[9] != kUdp || ip.size() < header + kUdpHeader) return {};
  if (load_big16(ip.data() + header + 2) != kEthercatPort) return {};
  return ip.subspan(header + kUdpHeader);
}

void read_ethercat(std::span<const std::uint8_t> payload, EcatFrame& frame) {
  constexpr std::size_t kHeader = 2;
  if (payload.size() < kHeader) {
    frame.kind = EcatFrame::Kind::bad;
    frame.fault = "it ends before the EtherCAT header";
    return;
  }
  const auto word = load_little<std::uint16_t>(payload.data());
  if (word >> 12 != 1) {
    frame.kind = EcatFrame::Kind::other_ethercat;
    return;
  }
  const std::size_t length = word & 0x7ffU;
  if (length > payload.size() - kHeader) {
    frame.kind = EcatFrame::Kind::bad;
    frame.fault = "the EtherCAT header announces more bytes than there are";
    return;
  }
  frame.kind = EcatFrame::Kind::datagrams;
  frame.body = payload.subspan(kHeader, length);
}

}  // namespace

std::string_view to_string(EcatCommand command) {
  constexpr std::array<std::string_view, kEcatCommands> kNames = {"NOP",  "APRD", "APWR", "APRW", "FPRD",
                                                                  "FPWR", "FPRW", "BRD",  "BWR",  "BRW",
                                                                  "LRD",  "LWR",  "LRW",  "ARMW", "FRMW"};
  const auto number = static_cast<std::size_t>(command);
  return number < kNames.size() ? kNames[number] : "?";
}

void parse_frame(std::span<const std::uint8_t> packet, bool whole, EcatFrame& frame) {
  frame.kind = EcatFrame::Kind::other;
  frame.esl.reset();
  frame.vlan_tags = 0;
  frame.udp = false;
  frame.source = 0;
  frame.body = {};
  if (packet.size() >= kEslSize && is_esl(packet.data())) {
    frame.esl = read_esl(packet.data());
    packet = packet.subspan(kEslSize);
  } else if (whole && packet.size() >= kEslSize && is_esl(packet.data() + packet.size() - kEslSize)) {
    frame.esl = read_esl(packet.data() + packet.size() - kEslSize);
    packet = packet.first(packet.size() - kEslSize);
  }
  if (packet.size() < kMacs + 2) return;
  // Bytes 4 to 11, first byte highest; the upper two belong to the receiver.
  frame.source = __builtin_bswap64(load_little<std::uint64_t>(packet.data() + 4)) & 0xffffffffffffU;
  std::uint16_t type = load_big16(packet.data() + kMacs);
  packet = packet.subspan(kMacs + 2);
  while (is_vlan_tag(type) && packet.size() >= 4) {
    ++frame.vlan_tags;
    frame.vlan = load_big16(packet.data()) & 0x0fffU;
    type = load_big16(packet.data() + 2);
    packet = packet.subspan(4);
  }
  if (type == kIpv4) {
    packet = udp_payload(packet);
    frame.udp = !packet.empty();
  }
  if (type == kEthercat || frame.udp) read_ethercat(packet, frame);
}

}  // namespace abbe
