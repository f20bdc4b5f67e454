#include "abbe/capture/frame_writer.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace abbe {
namespace {

constexpr std::size_t kLeastFrame = 60, kPcapHeader = 16;
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::uint32_t kSnapLength = 65535;

template <class T>
void append_little(std::string& out, T value) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), &value, sizeof value);
  out.append(bytes.data(), bytes.size());
}

void append_bytes(std::string& out, std::span<const std::uint8_t> bytes) {
  out.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

}  // namespace

FrameWriter::FrameWriter(const CaptureSettings& settings, std::int64_t listening_since_ns, SpoolFile& out)
    : settings_(settings), since_(listening_since_ns), out_(out) {
  std::string header;
  append_little<std::uint32_t>(header, 0xa1b23c4d);  // classic pcap, nanoseconds
  append_little<std::uint16_t>(header, 2);
  append_little<std::uint16_t>(header, 4);
  append_little<std::uint64_t>(header, 0);  // no time zone, no accuracy
  append_little<std::uint32_t>(header, kSnapLength);
  append_little<std::uint32_t>(header, 1);  // Ethernet
  ok_ = out_.write(header);
}

void FrameWriter::exchange(std::int64_t time_ns, std::span<const SentDatagram> datagrams) {
  if (settings_.forward) write(time_ns, datagrams, false);
  write(time_ns + kRoundTrip, datagrams, true);
  index_ = static_cast<std::uint8_t>(index_ + datagrams.size());
}

void FrameWriter::append_esl(std::int64_t time_ns, bool returning) {
  using namespace std::string_view_literals;
  packet_ += "\x01\x01\x05\x10\x00\x00"sv;
  // Bit 7 is port 0, bit 6 port 1; bit 13 says that the timestamp is valid.
  append_little<std::uint16_t>(packet_, static_cast<std::uint16_t>(0x2000U | (returning ? 0x40U : 0x80U)));
  append_little<std::int64_t>(packet_, time_ns - since_);
}

void FrameWriter::write(std::int64_t time_ns, std::span<const SentDatagram> datagrams, bool returning) {
  using namespace std::string_view_literals;
  packet_.assign(kPcapHeader, '\0');
  if (settings_.esl == EslPlace::header) append_esl(time_ns, returning);
  const std::size_t frame_begin = packet_.size();
  // The first slave marks what it sends back in the sender's address.
  packet_ += returning ? "\x01\x01\x05\x01\x00\x00\x02\x1b\x21\xab\xbe\x00\x88\xa4"sv
                       : "\x01\x01\x05\x01\x00\x00\x00\x1b\x21\xab\xbe\x00\x88\xa4"sv;
  std::size_t length = 0;
  for (const SentDatagram& d : datagrams) length += d.out.size() + 12;
  append_little(packet_, static_cast<std::uint16_t>(0x1000U | length));
  for (std::size_t i = 0; i < datagrams.size(); ++i) {
    const SentDatagram& d = datagrams[i];
    const std::uint16_t more = i + 1 < datagrams.size() ? 0x8000 : 0;
    packet_ += static_cast<char>(d.command);
    packet_ += static_cast<char>(static_cast<std::uint8_t>(index_ + i));
    append_little(packet_, d.address);
    append_little(packet_, static_cast<std::uint16_t>(d.out.size() | more));
    append_little<std::uint16_t>(packet_, 0);
    append_bytes(packet_, returning ? d.back : d.out);
    append_little<std::uint16_t>(packet_, returning ? d.working_counter : 0);
  }
  packet_.resize(std::max(packet_.size(), frame_begin + kLeastFrame), '\0');
  if (settings_.esl == EslPlace::trailer) append_esl(time_ns, returning);

  std::string header;
  append_little(header, static_cast<std::uint32_t>(time_ns / kSecond));
  append_little(header, static_cast<std::uint32_t>(time_ns % kSecond));
  append_little(header, static_cast<std::uint32_t>(packet_.size() - kPcapHeader));
  append_little(header, static_cast<std::uint32_t>(packet_.size() - kPcapHeader));
  packet_.replace(0, kPcapHeader, header);
  ok_ = ok_ && out_.write(packet_);
}

}  // namespace abbe
