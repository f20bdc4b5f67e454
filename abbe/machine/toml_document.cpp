#include "abbe/machine/toml_document.h"

#include <algorithm>
#include <utility>

// The parser is compiled into this file alone, without exceptions: its types stay in this room and the
// library needs no shared object of it. Some of its assertions do not hold for invalid texts ("[=]"),
// which the code after them handles: they must neither end the program nor, with NDEBUG, become
// promises to the optimiser.
#undef NDEBUG
#undef TOML_SHARED_LIB
#undef TOML_HEADER_ONLY
#define TOML_ASSERT(expression) static_assert(true)
#define TOML_SHARED_LIB 0
#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 0
#define TOML_ENABLE_FORMATTERS 0
#include <fmt/format.h>
#include <toml++/toml.h>

namespace abbe {
namespace {

// The parser recurses once per part of a dotted key, without a limit of its own.
constexpr std::size_t kMostKeyParts = 32;

Mark mark_of(const toml::source_region& source) {
  Mark mark{source.begin.line, source.begin.column, 1};
  if (source.end.line == source.begin.line && source.end.column > source.begin.column) {
    mark.length = source.end.column - source.begin.column;
  }
  return mark;
}

/// Follows strings and comments just far enough to count the dots of keys.
class KeyDepth {
 public:
  explicit KeyDepth(std::string_view text) : text_(text) {}

  /// The place of the first key with too many parts.
  std::optional<Mark> first_too_deep() {
    std::size_t dots = 0;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
        continue;
      }
      if (c == '"' || c == '\'') {
        skip_string(c);
        continue;
      }
      if (c == '\n') new_line();
      if (c == '.' && ++dots > kMostKeyParts) return Mark{line_, at_ - line_start_ + 1, 1};
      if (c == '\n' || c == '=' || c == ',' || c == '{' || c == '}' || c == '[' || c == ']') dots = 0;
      ++at_;
    }
    return std::nullopt;
  }

 private:
  void new_line() {
    ++line_;
    line_start_ = at_ + 1;
  }

  void skip_string(char quote) {
    const std::string triple(3, quote);
    const bool multi_line = text_.substr(at_, 3) == triple;
    at_ += multi_line ? 3 : 1;
    while (at_ < text_.size()) {
      if (quote == '"' && text_[at_] == '\\' && at_ + 1 < text_.size()) {
        if (text_[at_ + 1] == '\n') {
          ++at_;
          new_line();
          ++at_;
        } else {
          at_ += 2;
        }
        continue;
      }
      if (multi_line ? text_.substr(at_, 3) == triple : text_[at_] == quote) {
        at_ += multi_line ? 3 : 1;
        return;
      }
      if (text_[at_] == '\n') {
        if (!multi_line) return;  // unterminated: the parser reports it
        new_line();
      }
      ++at_;
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::size_t line_start_ = 0;
};

TomlNode convert(const toml::node& node) {
  TomlNode out;
  out.mark = mark_of(node.source());
  if (const auto* table = node.as_table()) {
    out.kind = TomlNode::Kind::table;
    out.entries.reserve(table->size());
    for (const auto& [key, value] : *table) {
      out.entries.push_back({std::string(key.str()), mark_of(key.source()), convert(value)});
    }
    std::stable_sort(out.entries.begin(), out.entries.end(), [](const TomlEntry& a, const TomlEntry& b) {
      return std::pair(a.mark.line, a.mark.column) < std::pair(b.mark.line, b.mark.column);
    });
  } else if (const auto* array = node.as_array()) {
    out.kind = TomlNode::Kind::array;
    out.items.reserve(array->size());
    for (const auto& item : *array) out.items.push_back(convert(item));
  } else if (const auto* integer = node.as_integer()) {
    out.kind = TomlNode::Kind::number;
    out.is_integer = true;
    out.integer = integer->get();
    out.number = static_cast<double>(out.integer);
  } else if (const auto* number = node.as_floating_point()) {
    out.kind = TomlNode::Kind::number;
    out.number = number->get();
  } else if (const auto* boolean = node.as_boolean()) {
    out.kind = TomlNode::Kind::boolean;
    out.boolean = boolean->get();
  } else if (const auto* text = node.as_string()) {
    out.kind = TomlNode::Kind::text;
    out.text = text->get();
  } else if (const auto* date = node.as_date()) {
    out.kind = TomlNode::Kind::date;
    out.text = fmt::format("{:04}-{:02}-{:02}", date->get().year, date->get().month, date->get().day);
  } else {
    out.kind = TomlNode::Kind::time;
  }
  return out;
}

}  // namespace

const TomlEntry* TomlNode::find(std::string_view key) const {
  const auto at =
      std::find_if(entries.begin(), entries.end(), [&](const TomlEntry& entry) { return entry.key == key; });
  return at == entries.end() ? nullptr : &*at;
}

std::optional<TomlNode> read_toml(std::string_view text, Findings& findings) {
  if (const auto too_deep = KeyDepth(text).first_too_deep()) {
    findings.error("E-TOML", *too_deep, fmt::format("a key of more than {} parts", kMostKeyParts),
                   "no key of this file has more than three", "remove the dots, or put the text in quotes");
    return std::nullopt;
  }
  const toml::parse_result result = toml::parse(text);
  if (!result) {
    findings.error(
        "E-TOML", mark_of(result.error().source()), std::string(result.error().description()),
        "the file is not valid TOML 1.0, so nothing after this place was read",
        "correct the syntax here (toml.io describes it); texts need quotes, each key appears once");
    return std::nullopt;
  }
  return convert(result.table());
}

std::string_view kind_name(TomlNode::Kind kind) {
  switch (kind) {
    case TomlNode::Kind::boolean:
      return "true or false";
    case TomlNode::Kind::number:
      return "a number";
    case TomlNode::Kind::text:
      return "a text";
    case TomlNode::Kind::date:
      return "a date";
    case TomlNode::Kind::time:
      return "a time";
    case TomlNode::Kind::array:
      return "a list";
    case TomlNode::Kind::table:
      break;
  }
  return "a table";
}

}  // namespace abbe
