#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <pugixml.hpp>

#include "abbe/capture/read_map.h"
#include "abbe/capture/slave_setup.h"

namespace abbe {
namespace {

constexpr int kFpwr = 5;
constexpr std::size_t kMostSlaves = 65535;

/// "1002", "#x1a03" or "0x1a03".
std::optional<std::uint64_t> number_of(std::string_view text) {
  int base = 10;
  if (text.starts_with("#x") || text.starts_with("0x")) {
    text.remove_prefix(2);
    base = 16;
  }
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::uint64_t> number_in(const pugi::xml_node& node, const char* child, std::uint64_t most) {
  const auto value = number_of(node.child_value(child));
  return value && *value <= most ? value : std::nullopt;
}

/// "00080001" as bytes; empty if it is none.
std::vector<std::uint8_t> bytes_of(std::string_view hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    std::uint8_t byte = 0;
    const auto [end, error] = std::from_chars(hex.data() + i, hex.data() + i + 2, byte, 16);
    if (error != std::errc() || end != hex.data() + i + 2) return {};
    bytes.push_back(byte);
  }
  return bytes;
}

std::optional<PdoType> type_of(std::string_view name) {
  if (name == "REAL" || name == "LREAL") return PdoType::real;
  for (const char* word : {"SINT", "INT", "DINT", "LINT"}) {
    if (name == word) return PdoType::signed_integer;
  }
  for (const char* word : {"BOOL", "BYTE", "WORD", "DWORD", "LWORD", "USINT", "UINT", "UDINT", "ULINT"}) {
    if (name == word) return PdoType::unsigned_integer;
  }
  return std::nullopt;
}

class EniReader {
 public:
  EniReader(std::string name, Diagnostics& findings) : name_(std::move(name)), findings_(findings) {}

  std::optional<ProcessMap> read(const pugi::xml_document& document) {
    const pugi::xml_node config = document.child("EtherCATConfig").child("Config");
    if (!config) {
      complain("this is XML, but has no EtherCATConfig/Config: no ENI file",
               "export the EtherCAT network information (ENI) from the master");
      return std::nullopt;
    }
    std::vector<SlaveSetup> slaves;
    for (const pugi::xml_node slave : config.children("Slave")) {
      if (slaves.size() < kMostSlaves) read_slave(slave, slaves);
    }
    if (broken_) return std::nullopt;
    ProcessMap map = map_of(slaves, findings_);
    map.origin = "ENI " + name_;
    if (map.objects.empty()) {
      complain("no slave of this ENI file maps process data: no FMMU is set by its initial commands",
               "export it from the configuration with which the machine runs");
      return std::nullopt;
    }
    if (const auto mistake = map_mistake(map)) {
      complain(*mistake, "export the ENI file again");
      return std::nullopt;
    }
    return map;
  }

 private:
  void complain(std::string message, std::string fix) {
    Diagnostic d;
    d.code = "E-ENI";
    d.place.file = name_;
    d.message = std::move(message);
    d.why = "the places of the signals in the frames are not known";
    d.fix = std::move(fix);
    findings_.push_back(std::move(d));
    broken_ = true;
  }

  void read_slave(const pugi::xml_node& node, std::vector<SlaveSetup>& slaves) {
    SlaveSetup slave;
    slave.name = node.child("Info").child_value("Name");
    const auto station = number_in(node.child("Info"), "PhysAddr", 0xffff);
    if (!station) {
      complain(fmt::format("slave '{}' has no station address (Info/PhysAddr)", slave.name),
               "export the ENI file again");
      return;
    }
    slave.station = static_cast<std::uint16_t>(*station);
    for (const pugi::xml_node command : node.child("InitCmds").children("InitCmd"))
      read_command(command, slave);
    const pugi::xml_node data = node.child("ProcessData");
    for (const char* kind : {"RxPdo", "TxPdo"}) {
      for (const pugi::xml_node pdo : data.children(kind)) read_pdo(pdo, slave);
    }
    read_assignment(data, slave);
    slaves.push_back(std::move(slave));
  }

  /// Registers as they are once the slave runs: commands that undo the set-up on the way down do not count.
  static void read_command(const pugi::xml_node& command, SlaveSetup& slave) {
    const bool on_the_way_up = std::any_of(command.children("Transition").begin(),
                                           command.children("Transition").end(), [](const pugi::xml_node& t) {
                                             return std::strcmp(t.child_value(), "IP") == 0 ||
                                                    std::strcmp(t.child_value(), "PS") == 0 ||
                                                    std::strcmp(t.child_value(), "SO") == 0;
                                           });
    const auto number = number_in(command, "Cmd", 255), station = number_in(command, "Adp", 0xffff);
    const auto offset = number_in(command, "Ado", 0xffff);
    if (!on_the_way_up || !number || *number != kFpwr || !station || *station != slave.station || !offset)
      return;
    set_registers(slave, static_cast<std::uint16_t>(*offset), bytes_of(command.child_value("Data")));
  }

  void read_pdo(const pugi::xml_node& node, SlaveSetup& slave) {
    const auto index = number_in(node, "Index", 0xffff);
    if (!index) return;
    std::vector<PdoEntry>& entries = slave.pdos[static_cast<std::uint16_t>(*index)];
    for (const pugi::xml_node entry : node.children("Entry")) {
      const auto object = number_in(entry, "Index", 0xffff), bits = number_in(entry, "BitLen", 0xffff);
      const auto subindex = number_in(entry, "SubIndex", 255);
      if (!object || !bits) {
        complain(
            fmt::format("slave {}: an entry of PDO {:04X} without Index or BitLen", slave.station, *index),
            "export the ENI file again");
        return;
      }
      entries.push_back({static_cast<std::uint16_t>(*object), static_cast<std::uint8_t>(subindex.value_or(0)),
                         static_cast<int>(*bits), type_of(entry.child_value("DataType"))});
    }
  }

  /// ProcessData/Sm2/Pdo lists the PDOs of a sync manager in order; without it the Sm attribute of the PDOs
  /// counts.
  static void read_assignment(const pugi::xml_node& data, SlaveSetup& slave) {
    for (int manager = 0; manager < 16; ++manager) {
      for (const pugi::xml_node pdo : data.child(fmt::format("Sm{}", manager).c_str()).children("Pdo")) {
        if (const auto index = number_of(pdo.child_value()); index && *index <= 0xffff)
          slave.assigned[manager].push_back(static_cast<std::uint16_t>(*index));
      }
    }
    for (const char* kind : {"RxPdo", "TxPdo"}) {
      for (const pugi::xml_node pdo : data.children(kind)) {
        const auto manager = number_of(pdo.attribute("Sm").value()), index = number_in(pdo, "Index", 0xffff);
        if (!manager || *manager > 15 || !index) continue;
        auto& list = slave.assigned[static_cast<int>(*manager)];
        const auto pdo_index = static_cast<std::uint16_t>(*index);
        if (std::find(list.begin(), list.end(), pdo_index) == list.end()) list.push_back(pdo_index);
      }
    }
  }

  std::string name_;
  Diagnostics& findings_;
  bool broken_ = false;
};

/// Line and column of a byte.
Place place_at(const std::string& name, std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  Place place;
  place.file = name;
  place.line = 1 + static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
  place.column =
      before.size() - (before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1) + 1;
  return place;
}

}  // namespace

Parsed<ProcessMap> read_eni(const std::string& name, std::string_view text) {
  Parsed<ProcessMap> parsed;
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size(), pugi::parse_default);
  if (!result) {
    Diagnostic d;
    d.code = "E-ENI";
    d.place = place_at(name, text, static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, result.offset)));
    d.message = fmt::format("this is not XML: {}", result.description());
    d.fix = "export the EtherCAT network information (ENI) from the master";
    parsed.diagnostics.push_back(std::move(d));
    return parsed;
  }
  parsed.value = EniReader(name, parsed.diagnostics).read(document);
  return parsed;
}

}  // namespace abbe
