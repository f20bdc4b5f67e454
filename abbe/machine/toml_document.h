#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/machine/findings.h"

namespace abbe {

struct TomlEntry;

/// A value of a TOML text with its place. Tables keep the order of the file.
struct TomlNode {
  enum class Kind : std::uint8_t { boolean, number, text, date, time, array, table };
  Kind kind = Kind::table;
  bool boolean = false;
  bool is_integer = false;
  Mark mark;
  double number = 0;               ///< may be nan or inf: TOML allows both
  std::int64_t integer = 0;        ///< exact, if is_integer
  std::string text;                ///< of a text; a date as YYYY-MM-DD
  std::vector<TomlNode> items;     ///< of an array
  std::vector<TomlEntry> entries;  ///< of a table

  [[nodiscard]] const TomlEntry* find(std::string_view key) const;
};

struct TomlEntry {
  std::string key;
  Mark mark;
  TomlNode value;
};

/// Reads TOML 1.0 into a tree. nullopt after a syntax error, which is reported (E-TOML); duplicate
/// keys are syntax errors. Total on any bytes: the depth of keys and values is limited.
[[nodiscard]] std::optional<TomlNode> read_toml(std::string_view text, Findings& findings);

/// "a number", "a text", ... for messages.
[[nodiscard]] std::string_view kind_name(TomlNode::Kind kind);

}  // namespace abbe
