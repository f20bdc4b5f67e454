#include "abbe/capture/learn.h"

namespace abbe {
namespace {

constexpr std::uint16_t kAlStatus = 0x0130, kLastRegister = 0x0fff;
constexpr std::uint16_t kFirstAssignment = 0x1C10, kAssignments = 32;

bool is_mapping(std::uint16_t index) {
  return (index >= 0x1600 && index < 0x1800) || (index >= 0x1A00 && index < 0x1C00);
}
bool is_assignment(std::uint16_t index) {
  return index >= kFirstAssignment && index < kFirstAssignment + kAssignments;
}

std::uint32_t number_of(std::span<const std::uint8_t> bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes.size() && i < 4; ++i) value |= std::uint32_t{bytes[i]} << (8 * i);
  return value;
}

PdoEntry entry_of(std::uint32_t value) {
  return {static_cast<std::uint16_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
          static_cast<int>(value & 0xffU), std::nullopt};
}

/// A list object: subindex 0 is its length, the others its items, each `size` bytes.
template <class Item, class Convert>
void set_list(std::vector<Item>& list, const SdoValue& value, std::size_t size, Convert convert) {
  if (value.complete) {
    if (value.data.size() < 2) return;
    list.clear();
    const std::size_t count = value.data[0];
    for (std::size_t i = 0; i < count && 2 + (i + 1) * size <= value.data.size(); ++i)
      list.push_back(convert(number_of(std::span(value.data).subspan(2 + i * size, size))));
  } else if (value.subindex == 0) {
    list.resize(number_of(value.data) & 0xffU);
  } else {
    if (list.size() < value.subindex) list.resize(value.subindex);
    list[value.subindex - 1U] = convert(number_of(value.data));
  }
}

/// True if a mailbox may lie there: where a sync manager says so, or anywhere in the memory if none is known.
bool may_be_mailbox(const SlaveSetup& slave, std::uint16_t offset) {
  bool known = false;
  for (int k = 0; k < 2; ++k) {
    const SyncManagerState sm = sync_manager_of(slave, k);
    if (!sm.mailbox || sm.length == 0) continue;
    if (sm.start == offset) return true;
    known = true;
  }
  return !known;
}

}  // namespace

void SetupListener::take(const SdoValue& value) {
  ++values_;
  SlaveSetup& slave = slaves_[value.station];
  if (is_assignment(value.index)) {
    set_list(slave.assigned[value.index - kFirstAssignment], value, 2,
             [](std::uint32_t v) { return static_cast<std::uint16_t>(v); });
  } else if (is_mapping(value.index)) {
    set_list(slave.pdos[value.index], value, 4, entry_of);
  }
}

void SetupListener::hear(const Datagram& d) {
  if (d.working_counter == 0) return;
  const bool addressed =
      d.command == EcatCommand::fprd || d.command == EcatCommand::fpwr || d.command == EcatCommand::fprw;
  if (d.command == EcatCommand::bwr) {
    for (auto& [station, slave] : slaves_) set_registers(slave, d.offset(), d.data);
    return;
  }
  if (!addressed) return;
  const auto [at, fresh] = slaves_.try_emplace(d.station());
  SlaveSetup& slave = at->second;
  slave.station = d.station();
  if (d.offset() <= kLastRegister) {
    set_registers(slave, d.offset(), d.data);
    if (d.offset() == kAlStatus && !d.data.empty() && d.command == EcatCommand::fprd)
      states_[d.station()] = d.data[0] & 0x0f;
    return;
  }
  if (!may_be_mailbox(slave, d.offset())) return;
  if (const auto value = sdo_.hear(d.station(), d.data)) take(*value);
}

std::vector<SlaveSetup> SetupListener::slaves() const {
  std::vector<SlaveSetup> list;
  for (const auto& [station, slave] : slaves_) list.push_back(slave);
  return list;
}

}  // namespace abbe
