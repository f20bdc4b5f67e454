#include "abbe/capture/slave_setup.h"

#include <fmt/core.h>

#include <algorithm>

#include "abbe/capture/frame.h"

namespace abbe {
namespace {

constexpr int kFmmus = 16, kSyncManagers = 16;
/// Of a map: far more than a bus carries. 16 bytes of nonsense can announce 16384 objects.
constexpr std::size_t kMostObjects = std::size_t{1} << 16;

/// The part of a slave's memory that appears in the logical image.
struct Window {
  std::uint64_t first = 0, end = 0;  ///< logical bits
  std::uint16_t physical = 0;
  std::uint8_t physical_bit = 0;
  bool input = false, output = false;
};

std::optional<Window> window_of(const SlaveSetup& slave, int k) {
  const std::uint8_t* r = slave.fmmu.data() + 16 * k;
  const std::uint64_t logical = load_little<std::uint32_t>(r);
  const std::uint64_t length = load_little<std::uint16_t>(r + 4);
  Window w;
  w.first = 8 * logical + (r[6] & 7U);
  w.end = 8 * (logical + length - 1) + (r[7] & 7U) + 1;
  w.physical = load_little<std::uint16_t>(r + 8);
  w.physical_bit = r[10] & 7U;
  w.input = (r[11] & 1) != 0;
  w.output = (r[11] & 2) != 0;
  const bool active = (r[12] & 1) != 0;
  if (!active || length == 0 || w.end <= w.first) return std::nullopt;
  return w;
}

/// The sync manager whose memory holds that address. Also one in mailbox mode: simple outputs use single
/// buffers.
std::optional<int> sync_manager_at(const SlaveSetup& slave, std::uint16_t physical) {
  for (int k = 0; k < kSyncManagers; ++k) {
    const SyncManagerState sm = sync_manager_of(slave, k);
    if (physical >= sm.start && physical < sm.start + sm.length) return k;
  }
  return std::nullopt;
}

PdoType type_of(const PdoEntry& entry) {
  if (entry.type) return *entry.type;
  const auto known = find_cia402(entry.index);
  return known && known->bits == entry.bits ? known->type : PdoType::unsigned_integer;
}

void add_unknown(const SlaveSetup& slave, const Window& w, PdoDirection direction, ProcessMap& map) {
  constexpr std::uint64_t kMost = 32;
  for (std::uint64_t at = w.first; at < w.end && map.objects.size() < kMostObjects; at += kMost) {
    PdoObject object;
    object.station = slave.station;
    object.direction = direction;
    object.type = PdoType::unsigned_integer;
    object.bits = static_cast<int>(std::min(kMost, w.end - at));
    object.bit = at;
    map.objects.push_back(object);
  }
}

void add_pdos(const SlaveSetup& slave, const Window& w, int manager, PdoDirection direction, ProcessMap& map,
              Diagnostics& findings) {
  const SyncManagerState sm = sync_manager_of(slave, manager);
  // Signed: an FMMU may begin behind the start of the sync manager.
  const auto origin = static_cast<std::int64_t>(w.first) - 8 * (w.physical - sm.start) - w.physical_bit;
  std::int64_t position = 0;
  for (const std::uint16_t pdo : slave.assigned.at(manager)) {
    const auto entries = slave.pdos.find(pdo);
    if (entries == slave.pdos.end()) continue;
    for (const PdoEntry& entry : entries->second) {
      const std::int64_t begin = origin + position, end = begin + entry.bits;
      position += entry.bits;
      if (entry.index == 0 || entry.bits < 1 || entry.bits > 64) continue;
      const auto first = static_cast<std::int64_t>(w.first), last = static_cast<std::int64_t>(w.end);
      if (end <= first || begin >= last) continue;
      if (map.objects.size() >= kMostObjects) return;
      if (begin < first || end > last) {
        Diagnostic d;
        d.severity = Severity::warning;
        d.code = "W-CAPTURE-MAP";
        d.message = fmt::format("slave {}: object {:04X}:{:02} is mapped only in part and is left out",
                                slave.station, entry.index, entry.subindex);
        findings.push_back(d);
        continue;
      }
      PdoObject object;
      object.station = slave.station;
      object.pdo = pdo;
      object.index = entry.index;
      object.subindex = entry.subindex;
      object.direction = direction;
      object.type = type_of(entry);
      object.bits = entry.bits;
      object.bit = static_cast<std::uint64_t>(begin);
      map.objects.push_back(object);
    }
  }
}

bool pdos_known(const SlaveSetup& slave, int manager) {
  const auto assigned = slave.assigned.find(manager);
  if (assigned == slave.assigned.end() || assigned->second.empty()) return false;
  // One unknown PDO leaves the places of all behind it unknown.
  return std::all_of(assigned->second.begin(), assigned->second.end(),
                     [&](std::uint16_t pdo) { return slave.pdos.count(pdo) > 0; });
}

}  // namespace

void set_registers(SlaveSetup& slave, std::uint16_t offset, std::span<const std::uint8_t> bytes) {
  const auto into = [&](std::uint16_t first, std::span<std::uint8_t> registers) {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const std::size_t place = std::size_t{offset} + i;
      if (place >= first && place < first + registers.size()) registers[place - first] = bytes[i];
    }
  };
  into(kFmmuRegisters, slave.fmmu);
  into(kSyncManagerRegisters, slave.sync_manager);
}

SyncManagerState sync_manager_of(const SlaveSetup& slave, int k) {
  const std::uint8_t* r = slave.sync_manager.data() + 8 * k;
  // Mode 2 of the control byte is a mailbox, 0 and 3 are buffers.
  return {load_little<std::uint16_t>(r), load_little<std::uint16_t>(r + 2), (r[4] & 3) == 2};
}

ProcessMap map_of(std::span<const SlaveSetup> slaves, Diagnostics& findings) {
  ProcessMap map;
  for (const SlaveSetup& slave : slaves) {
    for (int k = 0; k < kFmmus; ++k) {
      const std::optional<Window> w = window_of(slave, k);
      if (!w) continue;
      const std::optional<int> manager = sync_manager_at(slave, w->physical);
      if (!manager) continue;  // status registers and the like
      for (const PdoDirection direction : {PdoDirection::output, PdoDirection::input}) {
        if (!(direction == PdoDirection::input ? w->input : w->output)) continue;
        if (pdos_known(slave, *manager)) {
          add_pdos(slave, *w, *manager, direction, map, findings);
        } else {
          add_unknown(slave, *w, direction, map);
        }
      }
    }
  }
  if (map.objects.size() >= kMostObjects) {
    Diagnostic d;
    d.severity = Severity::warning;
    d.code = "W-CAPTURE-MAP";
    d.message = fmt::format("the slaves map {} objects or more; the rest is left out", kMostObjects);
    d.why = "no bus carries that many: registers were damaged or misunderstood";
    findings.push_back(d);
  }
  return map;
}

}  // namespace abbe
