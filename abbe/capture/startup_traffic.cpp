#include <algorithm>
#include <array>
#include <utility>

#include "abbe/capture/frame_writer.h"
#include "abbe/capture/slave_layout.h"

namespace abbe {
namespace {

constexpr std::uint16_t kMailboxOut = 0x1000, kMailboxIn = 0x1080, kMailboxSize = 128;
constexpr std::uint16_t kOutputBuffer = 0x1100, kInputBuffer = 0x1400;
constexpr std::uint16_t kStationRegister = 0x0010, kAlControl = 0x0120, kFmmu = 0x0600, kSyncManager = 0x0800;
constexpr std::uint16_t kOutputAssignment = 0x1C12, kInputAssignment = 0x1C13;

template <class T>
void put(std::vector<std::uint8_t>& bytes, T value) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// One exchange after the other, a step of time each.
class Steps {
 public:
  Steps(std::int64_t time, std::int64_t step, FrameWriter* writer)
      : time_(time), step_(step), writer_(writer) {}

  void write_register(EcatCommand command, std::uint16_t station, std::uint16_t offset,
                      const std::vector<std::uint8_t>& data) {
    send({command, device_address(station, offset), data, data, 1});
  }

  /// CoE: initiate an expedited SDO download, and its response.
  void download(std::uint16_t station, std::uint16_t index, std::uint8_t subindex, std::uint32_t value,
                int bytes) {
    counter_ = static_cast<std::uint8_t>(counter_ % 7 + 1);
    // 001 0 nn 1 1: download request, nn bytes of 4 unused, expedited, size given
    const auto command = static_cast<std::uint8_t>(0x23 | (4 - bytes) << 2);
    const auto out = mailbox(2, command, index, subindex, value);
    const auto in = mailbox(3, 0x60, index, subindex, 0);
    send({EcatCommand::fpwr, device_address(station, kMailboxOut), out, out, 1});
    send({EcatCommand::fprd, device_address(station, kMailboxIn), std::vector<std::uint8_t>(kMailboxSize), in,
          1});
  }

  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  [[nodiscard]] std::vector<std::uint8_t> mailbox(std::uint16_t service, std::uint8_t command,
                                                  std::uint16_t index, std::uint8_t subindex,
                                                  std::uint32_t value) const {
    std::vector<std::uint8_t> m;
    put<std::uint16_t>(m, 10);  // CoE header and SDO
    put<std::uint16_t>(m, 0);
    put<std::uint8_t>(m, 0);
    put(m, static_cast<std::uint8_t>(counter_ << 4 | 3));  // CoE
    put(m, static_cast<std::uint16_t>(service << 12));
    put(m, command);
    put(m, index);
    put(m, subindex);
    put(m, value);
    m.resize(kMailboxSize);
    return m;
  }
  void send(const SentDatagram& datagram) {
    if (writer_ != nullptr) writer_->exchange(time_, {&datagram, 1});
    time_ += step_;
    ++count_;
  }

  std::int64_t time_, step_;
  FrameWriter* writer_;
  std::size_t count_ = 0;
  std::uint8_t counter_ = 0;
};

std::vector<std::uint8_t> sync_manager(std::uint16_t start, std::uint16_t length, std::uint8_t control) {
  std::vector<std::uint8_t> r;
  put(r, start);
  put(r, length);
  put(r, control);
  put<std::uint8_t>(r, 0);  // status
  put<std::uint8_t>(r, 1);  // enabled
  put<std::uint8_t>(r, 0);
  return r;
}

std::vector<std::uint8_t> fmmu(const SlaveRange& range, std::uint16_t buffer) {
  std::vector<std::uint8_t> r;
  put(r, range.first_byte());
  put(r, range.bytes());
  put(r, static_cast<std::uint8_t>(range.begin % 8));
  put(r, static_cast<std::uint8_t>((range.end - 1) % 8));
  put(r, buffer);
  put(r, static_cast<std::uint8_t>(0));
  put(r, static_cast<std::uint8_t>(range.direction == PdoDirection::input ? 1 : 2));
  put<std::uint32_t>(r, 1);  // active
  return r;
}

std::uint16_t pdo_of(const PdoObject& object) {
  if (object.pdo != 0) return object.pdo;
  return object.direction == PdoDirection::output ? 0x1600 : 0x1A00;
}

/// The mapping entries of each PDO of a range: index, subindex and bits in one number; gaps are entries of
/// index 0.
std::vector<std::pair<std::uint16_t, std::vector<std::uint32_t>>> entries_of(const SlaveRange& range) {
  constexpr std::uint64_t kMostPadding = 128;
  std::vector<std::pair<std::uint16_t, std::vector<std::uint32_t>>> pdos;
  std::uint64_t at = range.begin;
  for (const PdoObject* object : range.objects) {
    if (pdos.empty() || pdos.back().first != pdo_of(*object)) pdos.push_back({pdo_of(*object), {}});
    std::vector<std::uint32_t>& entries = pdos.back().second;
    for (std::uint64_t gap = object->bit - at; gap > 0;) {
      const std::uint64_t part = std::min(gap, kMostPadding);
      entries.push_back(static_cast<std::uint32_t>(part));
      gap -= part;
    }
    entries.push_back(std::uint32_t{object->index} << 16 | std::uint32_t{object->subindex} << 8 |
                      static_cast<std::uint32_t>(object->bits));
    at = object->bit + static_cast<std::uint64_t>(object->bits);
  }
  return pdos;
}

void write_range(const SlaveRange& range, Steps& steps) {
  const bool output = range.direction == PdoDirection::output;
  const auto pdos = entries_of(range);
  for (const auto& [pdo, entries] : pdos) {
    steps.download(range.station, pdo, 0, 0, 1);
    for (std::size_t i = 0; i < entries.size(); ++i)
      steps.download(range.station, pdo, static_cast<std::uint8_t>(i + 1), entries[i], 4);
    steps.download(range.station, pdo, 0, static_cast<std::uint32_t>(entries.size()), 1);
  }
  const std::uint16_t assignment = output ? kOutputAssignment : kInputAssignment;
  steps.download(range.station, assignment, 0, 0, 1);
  std::uint8_t count = 0;
  for (const auto& [pdo, entries] : pdos) steps.download(range.station, assignment, ++count, pdo, 2);
  steps.download(range.station, assignment, 0, count, 1);

  const std::uint16_t buffer = output ? kOutputBuffer : kInputBuffer;
  const int manager = output ? 2 : 3, unit = output ? 0 : 1;
  steps.write_register(EcatCommand::fpwr, range.station,
                       static_cast<std::uint16_t>(kSyncManager + 8 * manager),
                       sync_manager(buffer, range.bytes(), output ? 0x64 : 0x20));
  steps.write_register(EcatCommand::fpwr, range.station, static_cast<std::uint16_t>(kFmmu + 16 * unit),
                       fmmu(range, buffer));
}

}  // namespace

std::vector<SlaveRange> slave_ranges(const ProcessMap& map) {
  std::vector<SlaveRange> ranges;
  for (const PdoObject& object : map.objects) {
    const std::uint64_t end = object.bit + static_cast<std::uint64_t>(object.bits);
    auto at = std::find_if(ranges.begin(), ranges.end(), [&](const SlaveRange& r) {
      return r.station == object.station && r.direction == object.direction;
    });
    if (at == ranges.end()) at = ranges.insert(at, {object.station, object.direction, object.bit, end, {}});
    at->begin = std::min(at->begin, object.bit);
    at->end = std::max(at->end, end);
    at->objects.push_back(&object);
  }
  for (SlaveRange& range : ranges) {
    std::sort(range.objects.begin(), range.objects.end(),
              [](const PdoObject* a, const PdoObject* b) { return a->bit < b->bit; });
  }
  std::sort(ranges.begin(), ranges.end(), [](const SlaveRange& a, const SlaveRange& b) {
    return std::pair(a.station, a.direction == PdoDirection::input) <
           std::pair(b.station, b.direction == PdoDirection::input);
  });
  return ranges;
}

bool can_be_mapped(const SlaveRange& range) {
  constexpr std::size_t kMostEntries = 254;
  std::vector<std::uint16_t> seen;
  for (const auto& [pdo, entries] : entries_of(range)) {
    if (entries.size() > kMostEntries || std::find(seen.begin(), seen.end(), pdo) != seen.end()) return false;
    seen.push_back(pdo);
  }
  return true;
}

std::size_t write_startup(const ProcessMap& map, std::int64_t time_ns, std::int64_t step_ns,
                          FrameWriter* writer) {
  Steps steps(time_ns, step_ns, writer);
  const std::vector<SlaveRange> ranges = slave_ranges(map);
  std::uint16_t position = 0;
  std::uint16_t station = 0;
  for (const SlaveRange& range : ranges) {
    if (position == 0 || range.station != station) {
      station = range.station;
      std::vector<std::uint8_t> address, state;
      put(address, station);
      put<std::uint16_t>(state, 2);  // PREOP
      steps.write_register(EcatCommand::apwr, static_cast<std::uint16_t>(-position), kStationRegister,
                           address);
      steps.write_register(EcatCommand::fpwr, station, kSyncManager,
                           sync_manager(kMailboxOut, kMailboxSize, 0x26));
      steps.write_register(EcatCommand::fpwr, station, kSyncManager + 8,
                           sync_manager(kMailboxIn, kMailboxSize, 0x22));
      steps.write_register(EcatCommand::fpwr, station, kAlControl, state);
      ++position;
    }
    write_range(range, steps);
  }
  return steps.count();
}

}  // namespace abbe
