#include "abbe/report/json_writer.h"

#include <cassert>
#include <cmath>
#include <utility>

#include "abbe/core/number.h"
#include "abbe/report/utf8.h"

namespace abbe {
void JsonWriter::separate() {
  if (after_key_) {
    after_key_ = false;
    return;
  }
  if (open_.empty()) return;
  Open& here = open_.back();
  if (!here.empty) text_ += ',';
  if (here.layout == Layout::lines) {
    text_ += '\n';
    text_.append(2 * open_.size(), ' ');
  } else if (!here.empty) {
    text_ += ' ';
  }
  here.empty = false;
}

JsonWriter& JsonWriter::begin(char open, Layout layout) {
  separate();
  if (!open_.empty() && open_.back().layout == Layout::one_line) layout = Layout::one_line;
  text_ += open;
  open_.push_back({open == '{' ? '}' : ']', layout, true});
  return *this;
}

JsonWriter& JsonWriter::end() {
  assert(!open_.empty() && !after_key_);
  const Open closed = open_.back();
  open_.pop_back();
  if (closed.layout == Layout::lines && !closed.empty) {
    text_ += '\n';
    text_.append(2 * open_.size(), ' ');
  }
  text_ += closed.close;
  if (open_.empty()) text_ += '\n';
  return *this;
}

JsonWriter& JsonWriter::key(std::string_view name) {
  assert(!open_.empty() && open_.back().close == '}' && !after_key_);
  separate();
  quote(name);
  text_ += ": ";
  after_key_ = true;
  return *this;
}

void JsonWriter::quote(std::string_view text) {
  static constexpr char kHex[] = "0123456789abcdef";
  text_ += '"';
  while (!text.empty()) {
    const char c = text.front();
    const std::size_t length = utf8_length(text);
    if (length == 0) {
      text_ += "\xEF\xBF\xBD";
      text.remove_prefix(1);
      continue;
    }
    if (c == '"' || c == '\\') {
      text_ += '\\';
      text_ += c;
    } else if (c == '\n') {
      text_ += "\\n";
    } else if (c == '\t') {
      text_ += "\\t";
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      const auto code = static_cast<unsigned char>(c);
      text_ += "\\u00";
      text_ += kHex[code >> 4];
      text_ += kHex[code & 15];
    } else {
      text_ += text.substr(0, length);
    }
    text.remove_prefix(length);
  }
  text_ += '"';
}

JsonWriter& JsonWriter::value(double number) {
  if (!std::isfinite(number)) return null();
  separate();
  text_ += to_shortest(number);
  return *this;
}

JsonWriter& JsonWriter::value(std::uint64_t number) {
  separate();
  text_ += std::to_string(number);
  return *this;
}

JsonWriter& JsonWriter::value(int number) {
  separate();
  text_ += std::to_string(number);
  return *this;
}

JsonWriter& JsonWriter::value(bool truth) {
  separate();
  text_ += truth ? "true" : "false";
  return *this;
}

JsonWriter& JsonWriter::value(std::string_view text) {
  separate();
  quote(text);
  return *this;
}

JsonWriter& JsonWriter::value(std::span<const double> numbers) {
  begin_array(Layout::one_line);
  for (const double number : numbers) value(number);
  return end();
}

JsonWriter& JsonWriter::value(const std::vector<std::string>& texts) {
  begin_array(Layout::one_line);
  for (const std::string& text : texts) value(std::string_view(text));
  return end();
}

JsonWriter& JsonWriter::null() {
  separate();
  text_ += "null";
  return *this;
}

std::string JsonWriter::take() { return std::exchange(text_, {}); }

}  // namespace abbe
