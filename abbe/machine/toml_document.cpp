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

// No key of ours has more than three.
constexpr std::size_t kMostKeyParts = 32;

Mark mark_of(const toml::source_region& source) {
  Mark mark{source.begin.line, source.begin.column, 1};
  if (source.end.line == source.begin.line && source.end.column > source.begin.column) {
    mark.length = source.end.column - source.begin.column;
  }
  return mark;
}

/// What the parser would not survive, found before it runs by following strings and comments: keys of
/// very many parts (it recurses once per part), and characters that are not ASCII where it asks
/// whether they are blank, which it answers for a few of them only. TOML allows them in texts and
/// comments, so there is nothing lost.
class Precheck {
 public:
  struct Fault {
    Mark mark;
    std::string message;
    std::string fix;
  };

  explicit Precheck(std::string_view text) : text_(text) {
    if (text_.starts_with("\xef\xbb\xbf")) at_ = line_start_ = 3;  // byte order mark
  }

  std::optional<Fault> first_fault() {
    std::size_t dots = 0;
    while (at_ < text_.size() && !fault_) {
      const char c = text_[at_];
      if (c == '#') {
        at_ = std::min(text_.find('\n', at_), text_.size());
        continue;
      }
      if (c == '"' || c == '\'') {
        skip_string(c);
        continue;
      }
      if (!is_ascii(c)) refuse_here("a character that is not ASCII outside of quotes");
      if (c == '.' && ++dots > kMostKeyParts) {
        fault_ = {here(), fmt::format("a key of more than {} parts", kMostKeyParts), "remove the dots"};
      }
      if (c == '\n') new_line();
      if (c == '\n' || c == '=' || c == ',' || c == '{' || c == '}' || c == '[' || c == ']') dots = 0;
      ++at_;
    }
    return fault_;
  }

 private:
  static bool is_ascii(char c) { return static_cast<unsigned char>(c) < 0x80; }

  [[nodiscard]] Mark here() const {
    // Columns count characters: all bytes but those that continue one.
    const std::string_view before = text_.substr(line_start_, at_ - line_start_);
    const auto characters = std::count_if(before.begin(), before.end(), [](char c) {
      return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U;
    });
    return {line_, static_cast<std::size_t>(characters) + 1, 1};
  }

  void refuse_here(std::string_view message) {
    fault_ = {here(), std::string(message), "use ASCII letters, or put the text in quotes"};
  }

  void new_line() {
    ++line_;
    line_start_ = at_ + 1;
  }

  void skip_string(char quote) {
    const std::string triple(3, quote);
    const bool multi_line = text_.substr(at_, 3) == triple;
    at_ += multi_line ? 3 : 1;
    while (at_ < text_.size() && !fault_) {
      if (quote == '"' && text_[at_] == '\\') {
        skip_escape(multi_line);
      } else if (multi_line ? text_.substr(at_, 3) == triple : text_[at_] == quote) {
        at_ += multi_line ? 3 : 1;
        return;
      } else {
        if (text_[at_] == '\n') {
          if (!multi_line) return;  // unterminated: the parser reports it
          new_line();
        }
        ++at_;
      }
    }
  }

  /// A backslash and what it escapes: one character, or in a multi-line string all blanks and line
  /// ends up to the next character.
  void skip_escape(bool multi_line) {
    ++at_;
    const std::size_t begin = at_;
    while (multi_line && at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) < 4) {
      if (text_[at_] == '\n') new_line();
      ++at_;
    }
    if (at_ == text_.size()) return;
    if (!is_ascii(text_[at_])) {
      refuse_here("a character that is not ASCII after a backslash");
    } else if (at_ == begin && text_[at_] != '\n') {
      ++at_;
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::size_t line_start_ = 0;
  std::optional<Fault> fault_;
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
  if (const auto fault = Precheck(text).first_fault()) {
    findings.error("E-TOML", fault->mark, fault->message, "the file is not valid TOML 1.0 here", fault->fix);
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
