#include "abbe/capture/read_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

using Kind = TomlNode::Kind;

const std::vector<std::string> kAxisKeys = {"station", "counts_per_mm", "counts_per_deg"};
const std::vector<std::string> kObjectKeys = {"axis", "station", "index", "subindex", "pdo",   "direction",
                                              "type", "address", "bit",   "name",     "scale", "unit"};

/// A whole number in [low, high], or nothing after E-VALUE.
std::optional<std::int64_t> read_whole(const TomlNode& node, std::int64_t low, std::int64_t high,
                                       std::string_view what, Findings& findings) {
  if (!expect_kind(node, Kind::number, what, findings)) return std::nullopt;
  if (node.is_integer && node.integer >= low && node.integer <= high) return node.integer;
  findings.error("E-VALUE", node.mark, fmt::format("{} is not a whole number from {} to {}", what, low, high),
                 "", "");
  return std::nullopt;
}

class MapReader {
 public:
  MapReader(Findings& findings, MapFile& file) : findings_(findings), file_(file) {}

  void read(const TomlNode& root) {
    refuse_other_keys(root, {"format", "axis", "object"}, "map file", findings_);
    const TomlEntry* format = root.find("format");
    if (format == nullptr || !format->value.is_integer || format->value.integer != 1)
      findings_.error("E-FORMAT", format != nullptr ? format->value.mark : Mark{1, 1, 1},
                      "this is not a map file of format 1", "", "begin the file with format = 1");
    if (const TomlEntry* axes = root.find("axis");
        axes != nullptr && expect_kind(axes->value, Kind::table, "axis", findings_)) {
      for (const TomlEntry& axis : axes->value.entries) read_axis(axis);
    }
    if (const TomlEntry* list = root.find("object");
        list != nullptr && expect_kind(list->value, Kind::array, "object", findings_)) {
      for (const TomlNode& object : list->value.items) read_object(object);
    }
  }

 private:
  const TomlNode* need(const TomlNode& table, std::string_view key, std::string_view what) {
    if (const TomlEntry* entry = table.find(key)) return &entry->value;
    findings_.error("E-MISSING-KEY", table.mark, fmt::format("{} has no {}", what, key), "", "");
    return nullptr;
  }

  std::optional<std::int64_t> whole(const TomlNode& table, std::string_view key, std::int64_t low,
                                    std::int64_t high, std::optional<std::int64_t> otherwise,
                                    std::string_view what) {
    if (otherwise && table.find(key) == nullptr) return otherwise;
    const TomlNode* node = need(table, key, what);
    return node != nullptr ? read_whole(*node, low, high, key, findings_) : std::nullopt;
  }

  void read_axis(const TomlEntry& entry) {
    const std::string what = "axis." + entry.key;
    if (!expect_kind(entry.value, Kind::table, what, findings_)) return;
    refuse_other_keys(entry.value, kAxisKeys, what, findings_);
    ServoAxis axis;
    axis.name = entry.key;
    const auto station = whole(entry.value, "station", 1, 65535, std::nullopt, what);
    const TomlEntry* mm = entry.value.find("counts_per_mm");
    const TomlEntry* deg = entry.value.find("counts_per_deg");
    if ((mm == nullptr) == (deg == nullptr)) {
      findings_.error("E-MISSING-KEY", entry.mark,
                      fmt::format("{} needs one of counts_per_mm and counts_per_deg", what), "", "");
      return;
    }
    const auto counts = read_value((mm != nullptr ? mm : deg)->value, "counts per unit", findings_);
    if (!station || !counts) return;
    if (*counts == 0 || !std::isfinite(1 / *counts)) {
      findings_.error("E-VALUE", entry.mark, what + " counts nothing per unit",
                      "positions in mm or degrees are counts divided by this",
                      "write what the drive is set to");
      return;
    }
    axis.station = static_cast<std::uint16_t>(*station);
    axis.counts_per_unit = *counts;
    axis.unit = mm != nullptr ? "mm" : "deg";
    file_.axes.push_back(std::move(axis));
  }

  std::optional<std::uint16_t> read_station(const TomlNode& table) {
    const TomlEntry* named = table.find("axis");
    if (named == nullptr) {
      const auto station = whole(table, "station", 1, 65535, std::nullopt, "object");
      return station ? std::optional(static_cast<std::uint16_t>(*station)) : std::nullopt;
    }
    const auto name = read_text(named->value, "axis", findings_);
    if (!name) return std::nullopt;
    for (const ServoAxis& axis : file_.axes) {
      if (axis.name == *name) return axis.station;
    }
    findings_.error("E-VALUE", named->value.mark, fmt::format("there is no [axis.{}]", *name), "", "");
    return std::nullopt;
  }

  bool read_type(const TomlNode& table, PdoObject& object) {
    const TomlNode* node = need(table, "type", "object");
    if (node == nullptr) return false;
    const auto text = read_text(*node, "type", findings_);
    if (!text) return false;
    struct Prefix {
      std::string_view word;
      PdoType type;
    };
    for (const Prefix& p : {Prefix{"uint", PdoType::unsigned_integer}, Prefix{"int", PdoType::signed_integer},
                            Prefix{"real", PdoType::real}, Prefix{"bits", PdoType::unsigned_integer}}) {
      if (!std::string_view(*text).starts_with(p.word)) continue;
      const std::string digits = text->substr(p.word.size());
      for (int bits = 1; bits <= 64; ++bits) {
        const bool usual = bits == 8 || bits == 16 || bits == 32 || bits == 64;
        const bool allowed = p.word == "bits" || (p.type == PdoType::real ? bits == 32 || bits == 64 : usual);
        if (!allowed || digits != std::to_string(bits)) continue;
        object.type = p.type;
        object.bits = bits;
        return true;
      }
    }
    findings_.error("E-VALUE", node->mark, fmt::format("{} is not a type", in_quotes(*text)), "",
                    "int8 to int64, uint8 to uint64, real32, real64, or bits1 to bits64");
    return false;
  }

  void read_object(const TomlNode& table) {
    if (!expect_kind(table, Kind::table, "object", findings_)) return;
    refuse_other_keys(table, kObjectKeys, "object", findings_);
    PdoObject object;
    const auto station = read_station(table);
    const auto index = whole(table, "index", 1, 65535, std::nullopt, "object");
    const auto subindex = whole(table, "subindex", 0, 255, 0, "object");
    const auto pdo = whole(table, "pdo", 0, 65535, 0, "object");
    const auto address = whole(table, "address", 0, (std::int64_t{1} << 32) - 1, std::nullopt, "object");
    const auto bit = whole(table, "bit", 0, 7, 0, "object");
    const bool typed = read_type(table, object);
    const TomlNode* direction = need(table, "direction", "object");
    const auto way = direction != nullptr
                         ? read_choice(*direction, {"input", "output"}, "direction", findings_)
                         : std::nullopt;
    if (!station || !index || !subindex || !pdo || !address || !bit || !typed || !way) return;
    object.station = *station;
    object.index = static_cast<std::uint16_t>(*index);
    object.subindex = static_cast<std::uint8_t>(*subindex);
    object.pdo = static_cast<std::uint16_t>(*pdo);
    object.bit = static_cast<std::uint64_t>(*address) * 8 + static_cast<std::uint64_t>(*bit);
    object.direction = *way == 0 ? PdoDirection::input : PdoDirection::output;
    if (read_labels(table, object)) file_.map.objects.push_back(std::move(object));
  }

  bool read_labels(const TomlNode& table, PdoObject& object) {
    if (const TomlEntry* name = table.find("name")) {
      const auto text = read_text(name->value, "name", findings_);
      if (!text) return false;
      object.name = *text;
    }
    if (const TomlEntry* unit = table.find("unit")) {
      const auto text = read_text(unit->value, "unit", findings_);
      if (!text) return false;
      object.unit = *text;
    }
    if (const TomlEntry* scale = table.find("scale")) {
      const auto value = read_value(scale->value, "scale", findings_);
      if (!value) return false;
      object.scale = *value;
    }
    // One alone would be completed by a guess: counts called mm, or a scale that the axis' own replaces.
    const bool with_unit = !object.unit.empty(), with_scale = table.find("scale") != nullptr;
    if (with_unit == with_scale) return true;
    findings_.error("E-MISSING-KEY", table.mark,
                    fmt::format("object has a {} but no {}", with_scale ? "scale" : "unit",
                                with_scale ? "unit" : "scale"),
                    "value = counts * scale in that unit", "give both, or neither and the axis' are used");
    return false;
  }

  Findings& findings_;
  MapFile& file_;
};

}  // namespace

Parsed<MapFile> read_map(const std::string& name, std::string_view text) {
  Parsed<MapFile> parsed;
  Findings findings(name, text, parsed.diagnostics);
  const std::optional<TomlNode> root = read_toml(text, findings);
  if (!root) return parsed;
  MapFile file;
  MapReader(findings, file).read(*root);
  if (findings.error_count() == 0) {
    if (const auto mistake = map_mistake(file.map))
      findings.error("E-VALUE", {}, *mistake, "", "correct address, bit or type");
  }
  if (findings.error_count() > 0) return parsed;
  file.map.origin = "map file " + name;
  parsed.value = std::move(file);
  return parsed;
}

}  // namespace abbe
