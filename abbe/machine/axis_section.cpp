#include "abbe/machine/axis_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "abbe/machine/machine_sections.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

constexpr std::array kKinds{FactorKind::location, FactorKind::along,   FactorKind::across,
                            FactorKind::motion,   FactorKind::thermal, FactorKind::component,
                            FactorKind::dynamic};

const std::vector<std::string> kAxisKeys{"type",  "direction",   "range",       "origin",  "location",
                                         "order", "errors_seen", "measured_at", "address", "correctable"};

std::vector<Factor> without_motion(std::vector<Factor> order) {
  std::erase_if(order, [](const Factor& factor) { return factor.kind == FactorKind::motion; });
  return order;
}

std::optional<Factor> factor_of(std::string_view word) {
  const bool inverse = !word.empty() && word.front() == '-';
  if (inverse) word.remove_prefix(1);
  for (const FactorKind kind : kKinds) {
    if (word == factor_word(kind) && !(inverse && kind == FactorKind::motion)) return Factor{kind, inverse};
  }
  return std::nullopt;
}

std::vector<std::string> all_factor_words() {
  std::vector<std::string> words;
  for (const FactorKind kind : kKinds) {
    words.emplace_back(factor_word(kind));
    if (kind != FactorKind::motion) words.push_back("-" + words.back());
  }
  return words;
}

/// One axis: its element of the chain, its table, and the body that comes of both.
class AxisReader {
 public:
  AxisReader(const ChainElement& element, const TomlEntry* entry, const FileUnits& units, Findings& findings)
      : element_(element),
        table_(entry != nullptr && entry->value.kind == TomlNode::Kind::table ? &entry->value : nullptr),
        what_("axis." + element.name),
        units_(units),
        findings_(findings) {
    notes_.mark = entry != nullptr ? entry->mark : element.mark;
  }

  void read(AxisSection& out) {
    body_.name = element_.name;
    body_.branch = element_.branch;
    if (table_ != nullptr) refuse_other_keys(*table_, kAxisKeys, "[" + what_ + "]", findings_);
    read_type_and_direction();
    read_geometry();
    read_order();
    read_errors_seen();
    read_address();
    out.bodies.push_back(std::move(body_));
    out.notes.push_back(notes_);
  }

 private:
  const TomlEntry* find(std::string_view key) const {
    return table_ == nullptr ? nullptr : table_->find(key);
  }
  std::string key(std::string_view name) const { return fmt::format("{}.{}", what_, name); }

  void read_type_and_direction() {
    const auto defaults = letter_defaults(element_.name.front());
    std::optional<AxisType> type;
    bool type_failed = false;
    if (const auto* entry = find("type")) {
      const auto choice = read_choice(entry->value, {"linear", "rotary", "fixed"}, key("type"), findings_);
      if (choice) type = static_cast<AxisType>(*choice);
      type_failed = !choice;
    }
    if (!type && !type_failed && !defaults) {
      findings_.error("E-AXIS-TYPE", notes_.mark, fmt::format("axis {} has no type", element_.name),
                      "only X Y Z U V W, A B C and S say by their letter what they are",
                      fmt::format("add type = \"linear\", \"rotary\" or \"fixed\" to [{}]", what_));
      type_failed = true;
    }
    body_.type = type.value_or(defaults ? defaults->type : AxisType::fixed);

    if (const auto* entry = find("direction")) {
      body_.direction = read_direction(entry->value, key("direction"), findings_).value_or(Vec3::UnitX());
      return;
    }
    if (defaults && defaults->type == body_.type) body_.direction = defaults->direction;
    if (body_.type == AxisType::fixed || type_failed) return;
    if (!defaults || defaults->type != body_.type) {
      findings_.error(
          "E-DIRECTION-NEEDED", notes_.mark, fmt::format("axis {} has no direction", element_.name),
          "its letter does not say which way an axis of this type moves",
          fmt::format("add direction = [x, y, z] to [{}]: the motion of this body in bed axes for "
                      "an increasing command",
                      what_));
    } else if (body_.branch == Branch::workpiece && body_.type == AxisType::rotary) {
      findings_.error("E-DIRECTION-NEEDED", notes_.mark,
                      fmt::format("rotary axis {} carries the workpiece and has no direction", element_.name),
                      "controls differ in the sense of rotary tables, and a wrong sign doubles the error",
                      fmt::format("turn the table by +10 degrees, watch it, and add direction = [x, y, z] to "
                                  "[{}] (right-handed)",
                                  what_));
    } else if (body_.branch == Branch::workpiece) {
      body_.direction = -body_.direction;  // ISO 841: a positive command moves the tool relative to the work
    }
  }

  void read_geometry() {
    if (const auto* entry = find("origin")) {
      body_.origin =
          read_vector(entry->value, units_.length, key("origin"), findings_).value_or(Vec3::Zero());
    }
    if (const auto* entry = find("measured_at")) {
      body_.measured_at = read_vector(entry->value, units_.length, key("measured_at"), findings_);
    }
    if (const auto* entry = find("range")) {
      if (body_.type == AxisType::fixed) {
        refuse_for_fixed(*entry, "a body without motion has no travel");
      } else {
        const double unit = body_.type == AxisType::rotary ? units_.angle : units_.length;
        body_.range = read_interval(entry->value, unit, key("range"), findings_);
      }
    }
    if (const auto* entry = find("correctable")) {
      if (body_.type == AxisType::fixed) refuse_for_fixed(*entry, "a body without motion corrects nothing");
      body_.correctable = read_flag(entry->value, key("correctable"), findings_).value_or(true);
    }
    if (body_.type == AxisType::fixed) body_.correctable = false;
  }

  void refuse_for_fixed(const TomlEntry& entry, std::string_view why) {
    findings_.error("E-FIXED-BODY", entry.mark,
                    fmt::format("{} on the fixed body {}", in_quotes(entry.key), element_.name),
                    std::string(why), "remove the key, or give the axis the type it has");
  }

  void read_order() {
    const bool fixed = body_.type == AxisType::fixed;
    body_.order = fixed ? without_motion(frame_order()) : line_order();
    const TomlEntry* location = find("location");
    const TomlEntry* order = find("order");
    if (location != nullptr && order != nullptr) {
      findings_.error("E-ORDER-AND-LOCATION", std::max(location, order)->mark,
                      fmt::format("[{}] has both location and order", what_),
                      "each says how location errors act; together they could contradict",
                      "keep one of them");
    }
    if (location != nullptr) read_location(*location);
    if (order != nullptr) read_explicit_order(*order);
  }

  void read_location(const TomlEntry& entry) {
    const std::vector<std::string> words{"line", "frame", "after"};
    const auto choice = read_choice(entry.value, words, key("location"), findings_);
    if (!choice) return;
    const bool fixed = body_.type == AxisType::fixed;
    if (fixed && *choice == 0) {
      findings_.error("E-FIXED-BODY", entry.value.mark,
                      fmt::format("location = \"line\" on the fixed body {}", element_.name),
                      "a body without motion has no axis line",
                      "use \"frame\" (the default of fixed bodies)");
      return;
    }
    body_.location = words[*choice];
    const std::array orders{line_order(), frame_order(), after_order()};
    body_.order = fixed ? without_motion(orders[*choice]) : orders[*choice];
  }

  void read_explicit_order(const TomlEntry& entry) {
    if (!expect_kind(entry.value, TomlNode::Kind::array, key("order"), findings_)) return;
    const std::size_t errors_before = findings_.error_count();
    std::vector<Factor> factors;
    for (const TomlNode& item : entry.value.items) {
      const auto word = read_text(item, "a factor of " + key("order"), findings_);
      if (!word) continue;
      const auto factor = factor_of(*word);
      if (!factor) {
        findings_.error(
            "E-ORDER", item.mark, fmt::format("{} is not a factor", in_quotes(*word)),
            "factors: location along across motion thermal static dynamic; all but motion may have "
            "a minus",
            suggestion(*word, all_factor_words(), "use one of these words"));
      } else if (std::find(factors.begin(), factors.end(), *factor) != factors.end()) {
        findings_.error("E-ORDER", item.mark, fmt::format("{} appears twice", in_quotes(*word)),
                        "each factor acts at most once per sign", "remove one of them");
      } else if (body_.type == AxisType::fixed && factor->kind == FactorKind::motion) {
        findings_.error("E-ORDER", item.mark, fmt::format("motion of the fixed body {}", element_.name),
                        "a body without motion has no motion factor", "remove \"motion\"");
      } else if (body_.type == AxisType::fixed && find("direction") == nullptr &&
                 (factor->kind == FactorKind::along || factor->kind == FactorKind::across)) {
        findings_.error("E-ORDER", item.mark,
                        fmt::format("{} of a fixed body without direction", in_quotes(*word)),
                        "along and across are told apart by the direction of the axis",
                        "use \"location\", or state direction");
      } else {
        factors.push_back(*factor);
      }
    }
    if (findings_.error_count() != errors_before) return;
    if (body_.type != AxisType::fixed &&
        std::find(factors.begin(), factors.end(), Factor{}) == factors.end()) {
      findings_.error("E-ORDER", entry.value.mark, fmt::format("{} does not name motion", key("order")),
                      "without it the axis would not move", "put \"motion\" where the axis moves");
      return;
    }
    body_.order = std::move(factors);
    notes_.explicit_order = true;
    notes_.order = entry.value.mark;
    warn_of_location_twice();
  }

  /// location and its parts along and across with the same sign count the same error twice.
  void warn_of_location_twice() {
    for (const bool inverse : {false, true}) {
      const auto has = [&](FactorKind kind) {
        return std::find(body_.order.begin(), body_.order.end(), Factor{kind, inverse}) != body_.order.end();
      };
      if (has(FactorKind::location) && (has(FactorKind::along) || has(FactorKind::across))) {
        findings_.warning(
            "W-LOCATION-TWICE", notes_.order, fmt::format("{} applies location errors twice", key("order")),
            "along and across are the two parts of location", "use location or its parts, not both");
      }
    }
  }

  void read_errors_seen() {
    const TomlEntry* entry = find("errors_seen");
    if (entry == nullptr) return;
    body_.errors_seen_stated = true;
    const auto choice = read_choice(entry->value, {"body", "tool"}, key("errors_seen"), findings_);
    if (!choice) return;
    if (*choice == 1 && body_.branch == Branch::tool) {
      findings_.error("E-ERRORS-SEEN", entry->value.mark,
                      fmt::format("errors_seen = \"tool\" on {}, which carries the tool", element_.name),
                      "on the tool branch the error of the body is the error of the tool; inverting it would "
                      "double the deviation",
                      "remove the key");
      return;
    }
    body_.errors_seen_at_tool = *choice == 1;
  }

  void read_address() {
    if (body_.type != AxisType::fixed && body_.name.size() == 1) body_.address = body_.name;
    const TomlEntry* entry = find("address");
    if (entry == nullptr) return;
    if (body_.type == AxisType::fixed) {
      refuse_for_fixed(*entry, "a body without motion is not commanded");
      return;
    }
    const auto text = read_text(entry->value, key("address"), findings_);
    if (!text) return;
    const auto is_word = [](std::string_view word) {
      return !word.empty() && word.front() >= 'A' && word.front() <= 'Z' &&
             std::all_of(word.begin() + 1, word.end(),
                         [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; });
    };
    if (!is_word(*text)) {
      findings_.error("E-ADDRESS", entry->value.mark,
                      fmt::format("{} is not a word of programs", in_quotes(*text)),
                      "an address is a capital letter, perhaps followed by capital letters, digits and _",
                      "write it as the control does, such as \"X\" or \"C1\"");
      return;
    }
    body_.address = *text;
  }

  const ChainElement& element_;
  const TomlNode* table_;
  std::string what_;
  const FileUnits& units_;
  Findings& findings_;
  Body body_;
  AxisNotes notes_;
};

void refuse_shared_addresses(const AxisSection& section, Findings& findings) {
  for (std::size_t i = 0; i < section.bodies.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (section.bodies[i].address.empty() || section.bodies[i].address != section.bodies[j].address)
        continue;
      findings.error("E-ADDRESS", section.notes[i].mark,
                     fmt::format("axes {} and {} have the same address '{}'", section.bodies[j].name,
                                 section.bodies[i].name, section.bodies[i].address),
                     "a word of a program must mean one axis", "give one of them another address");
    }
  }
}

}  // namespace

std::string_view factor_word(FactorKind kind) {
  switch (kind) {
    case FactorKind::location:
      return "location";
    case FactorKind::along:
      return "along";
    case FactorKind::across:
      return "across";
    case FactorKind::thermal:
      return "thermal";
    case FactorKind::component:
      return "static";
    case FactorKind::dynamic:
      return "dynamic";
    case FactorKind::motion:
      break;
  }
  return "motion";
}

AxisSection read_axes(const TomlNode& root, const std::vector<ChainElement>& chain, const FileUnits& units,
                      Findings& findings) {
  static const TomlNode kNoAxes;
  const TomlNode* found = find_table(root, "axis", findings);
  const TomlNode& axes = found == nullptr ? kNoAxes : *found;

  std::vector<std::string> names;
  for (const ChainElement& element : chain) names.push_back(element.name);
  for (const TomlEntry& entry : axes.entries) {
    if (std::find(names.begin(), names.end(), entry.key) == names.end()) {
      findings.error(
          "E-AXIS-UNKNOWN", entry.mark, fmt::format("axis {} is not in the chain", in_quotes(entry.key)),
          names.empty() ? "the chain has no axes" : "the chain has " + listed(names, "and"),
          entry.key == "t"   ? "the tool is described in [tool]"
          : entry.key == "w" ? "the workpiece is described in [workpiece]"
                             : suggestion(entry.key, names, "add it to machine.chain, or remove the table"));
    } else {
      static_cast<void>(expect_kind(entry.value, TomlNode::Kind::table, "axis." + entry.key, findings));
    }
  }

  AxisSection section;
  for (const ChainElement& element : chain) {
    AxisReader(element, axes.find(element.name), units, findings).read(section);
  }
  refuse_shared_addresses(section, findings);

  int moving = 0;
  for (std::size_t i = 0; i < section.bodies.size(); ++i) {
    if (section.bodies[i].type == AxisType::fixed) continue;
    section.bodies[i].axis = moving++;
    if (moving == kMaxAxes + 1) {
      findings.error("E-TOO-MANY-AXES", section.notes[i].mark,
                     fmt::format("more than {} moving axes", kMaxAxes), "this program has room for no more",
                     "describe axes that stand still as type = \"fixed\"");
    }
  }
  return section;
}

}  // namespace abbe
