#include "abbe/capture/coe.h"

#include <algorithm>

#include "abbe/capture/frame.h"

namespace abbe {
namespace {

constexpr std::size_t kMailboxHeader = 6, kCoeHeader = 2, kInitiate = 8, kSegmentHeader = 1;
constexpr std::uint8_t kCoe = 3;
constexpr std::size_t kMostValue = std::size_t{1} << 20;

using Bytes = std::span<const std::uint8_t>;

void append(std::vector<std::uint8_t>& to, Bytes bytes) {
  if (to.size() + bytes.size() <= kMostValue) to.insert(to.end(), bytes.begin(), bytes.end());
}

/// What an initiating message carries: up to four bytes in it, or a size and what fits behind.
void take_first(Bytes sdo, std::vector<std::uint8_t>& data, std::size_t& expected) {
  const std::uint8_t command = sdo[0];
  if ((command & 2) != 0) {
    const std::size_t size = (command & 1) != 0 ? 4U - (command >> 2 & 3U) : 4U;
    append(data, sdo.subspan(4, size));
    expected = size;
    return;
  }
  expected = load_little<std::uint32_t>(sdo.data() + 4);
  append(data, sdo.subspan(kInitiate, std::min(expected, sdo.size() - kInitiate)));
}

/// A segment: the rest of the message; of the shortest one a count of unused bytes is in the command.
void take_segment(Bytes sdo, std::vector<std::uint8_t>& data) {
  constexpr std::size_t kShortest = 7;
  std::size_t size = sdo.size() - kSegmentHeader;
  if (size == kShortest) size -= sdo[0] >> 1 & 7U;
  append(data, sdo.subspan(kSegmentHeader, size));
}

}  // namespace

std::optional<SdoValue> SdoListener::finish(std::uint16_t station) {
  const auto at = transfers_.find(station);
  if (at == transfers_.end()) return std::nullopt;
  SdoValue value = std::move(at->second.value);
  const bool whole = value.data.size() >= at->second.expected;
  transfers_.erase(at);
  if (!whole) return std::nullopt;
  return value;
}

void SdoListener::request(std::uint16_t station, Bytes sdo) {
  const int kind = sdo[0] >> 5;
  if (kind == 0) {  // download segment
    const auto at = transfers_.find(station);
    if (at == transfers_.end() || !at->second.value.download) return;
    take_segment(sdo, at->second.value.data);
    at->second.last = (sdo[0] & 1) != 0;
  } else if ((kind == 1 || kind == 2) && sdo.size() >= kInitiate) {  // initiate download, upload
    Transfer transfer;
    transfer.value.station = station;
    transfer.value.index = load_little<std::uint16_t>(sdo.data() + 1);
    transfer.value.subindex = sdo[3];
    transfer.value.complete = (sdo[0] & 0x10) != 0;
    transfer.value.download = kind == 1;
    if (kind == 1) take_first(sdo, transfer.value.data, transfer.expected);
    transfer.last = transfer.value.data.size() >= transfer.expected;
    transfers_[station] = std::move(transfer);
  } else if (kind == 4) {
    ++aborted_;
    transfers_.erase(station);
  }
}

std::optional<SdoValue> SdoListener::respond(std::uint16_t station, Bytes sdo) {
  const auto at = transfers_.find(station);
  if (at == transfers_.end()) return std::nullopt;
  Transfer& transfer = at->second;
  switch (sdo[0] >> 5) {
    case 3:  // download begun
    case 1:  // download segment taken
      if (transfer.value.download && transfer.last) return finish(station);
      break;
    case 2:  // upload begun
      if (transfer.value.download || sdo.size() < kInitiate) break;
      transfer.value.data.clear();
      take_first(sdo, transfer.value.data, transfer.expected);
      if (transfer.value.data.size() >= transfer.expected) return finish(station);
      break;
    case 0:  // upload segment
      if (transfer.value.download) break;
      take_segment(sdo, transfer.value.data);
      if ((sdo[0] & 1) != 0) return finish(station);
      break;
    default:
      ++aborted_;
      transfers_.erase(at);
  }
  return std::nullopt;
}

std::optional<SdoValue> SdoListener::hear(std::uint16_t station, Bytes mailbox) {
  if (mailbox.size() < kMailboxHeader + kCoeHeader + kSegmentHeader) return std::nullopt;
  const std::size_t length = load_little<std::uint16_t>(mailbox.data());
  if ((mailbox[5] & 0x0f) != kCoe || length < kCoeHeader + kSegmentHeader ||
      length > mailbox.size() - kMailboxHeader)
    return std::nullopt;
  const Bytes coe = mailbox.subspan(kMailboxHeader, length), sdo = coe.subspan(kCoeHeader);
  switch (load_little<std::uint16_t>(coe.data()) >> 12) {
    case 2:
      request(station, sdo);
      break;
    case 3:
      return respond(station, sdo);
    default:
      break;
  }
  return std::nullopt;
}

}  // namespace abbe
