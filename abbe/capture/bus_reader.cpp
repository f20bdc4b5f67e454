#include "abbe/capture/bus_reader.h"

#include <algorithm>

namespace abbe {
namespace {

constexpr std::uint64_t kLocalBit = std::uint64_t{2} << 40;
constexpr std::size_t kMostSenders = 64;

/// What stays the same on the way through the slaves. Positions are counted up by every slave.
std::uint64_t signature_of(std::span<const Datagram> datagrams) {
  const Datagram& first = datagrams.front();
  using C = EcatCommand;
  const bool counted = (first.command >= C::aprd && first.command <= C::aprw) ||
                       (first.command >= C::brd && first.command <= C::brw) || first.command == C::armw;
  const std::uint64_t address = counted ? first.address & 0xffff0000U : first.address;
  return address | std::uint64_t{first.data.size()} << 32 |
         std::uint64_t{static_cast<std::uint8_t>(first.command)} << 48 |
         std::uint64_t{datagrams.size() & 0xffU} << 56;
}

}  // namespace

FileResult<BusReader> BusReader::open(const std::string& path) {
  FileResult<PacketSource> source = PacketSource::open(path);
  if (auto* error = std::get_if<FileError>(&source)) return std::move(*error);
  return BusReader(std::move(std::get<PacketSource>(source)));
}

bool BusReader::read_datagrams(BusFrame& frame) {
  DatagramReader reader(frame.ethernet.body);
  // Kept in registers: what is written below could be anything to the compiler.
  Datagram* out = datagrams_.data();
  std::size_t count = 0, room = datagrams_.size();
  unsigned counted = 0;
  for (;; ++count) {
    if (count == room) {
      datagrams_.resize(2 * count + 16);
      out = datagrams_.data();
      room = datagrams_.size();
    }
    if (!reader.next(out[count])) break;
    counted |= out[count].working_counter;
  }
  if (reader.bad()) {
    frame.ethernet.kind = EcatFrame::Kind::bad;
    frame.ethernet.fault = "a datagram announces more bytes than the frame has";
  }
  frame.datagrams = {out, count};
  return counted != 0;
}

void BusReader::find_partner(BusFrame& frame, bool counted) {
  const std::uint64_t sender = frame.ethernet.source & ~kLocalBit;
  const bool marked = (frame.ethernet.source & kLocalBit) != 0;
  const bool known = sender == last_plain_ || std::find(plain_.begin(), plain_.end(), sender) != plain_.end();
  if (!marked && !known && plain_.size() < kMostSenders) plain_.push_back(sender);
  if (!marked) last_plain_ = sender;
  frame.returning = counted || (marked && known);

  Sent& slot = sent_[frame.datagrams.front().index];
  const std::uint64_t signature = signature_of(frame.datagrams);
  if (!frame.returning) {
    slot = {frame.number, signature};
  } else if (slot.number != 0 && slot.signature == signature) {
    frame.partner = slot.number;
    slot.number = 0;
  }
}

bool BusReader::next(BusFrame& frame) {
  if (!source_.next(frame.packet)) return false;
  frame.number = ++number_;
  frame.returning = false;
  frame.partner = 0;
  frame.datagrams = {};
  parse_frame(frame.packet.bytes, frame.packet.bytes.size() >= frame.packet.original, frame.ethernet);
  if (frame.ethernet.kind != EcatFrame::Kind::datagrams) return true;
  const bool counted = read_datagrams(frame);
  if (const auto& esl = frame.ethernet.esl; esl && (esl->alignment_error || esl->crc_error)) {
    frame.ethernet.kind = EcatFrame::Kind::bad;
    frame.ethernet.fault = "the switch link marks it as damaged (CRC or alignment)";
  }
  if (frame.datagrams.empty()) return true;
  find_partner(frame, counted);
  // What a damaged frame said on its way out is not known when its partner returns.
  if (frame.ethernet.kind == EcatFrame::Kind::bad) sent_[frame.datagrams.front().index].number = 0;
  return true;
}

}  // namespace abbe
