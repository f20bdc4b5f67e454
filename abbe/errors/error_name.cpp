#include "abbe/errors/error_name.h"

#include <algorithm>
#include <cstddef>

namespace abbe {
namespace {

constexpr std::string_view kDirections = "XYZABC";

bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// A chain element: a capital letter, then digits.
bool is_element(std::string_view text) {
  return !text.empty() && is_capital(text.front()) && std::all_of(text.begin() + 1, text.end(), is_digit);
}

}  // namespace

std::optional<ErrorName> read_error_name(std::string_view text) {
  ErrorName name;
  if (text.size() >= 3 && text[1] == '0') {  // C0Y is short for EC0Y
    name.error_class = ErrorClass::location;
  } else {
    if (text.empty()) return std::nullopt;
    if (text[0] == 'E') {
      name.error_class = ErrorClass::component;
    } else if (text[0] == 'T') {
      name.error_class = ErrorClass::thermal;
    } else if (text[0] == 'D') {
      name.error_class = ErrorClass::dynamic;
    } else {
      return std::nullopt;
    }
    text.remove_prefix(1);
  }
  if (text.size() < 2) return std::nullopt;
  const std::size_t direction = kDirections.find(text[0]);
  if (direction == std::string_view::npos) return std::nullopt;
  name.direction = static_cast<int>(direction);
  text.remove_prefix(1);
  if (text[0] == '0') {
    if (name.error_class == ErrorClass::component) name.error_class = ErrorClass::location;
    if (name.error_class != ErrorClass::location) return std::nullopt;
    text.remove_prefix(1);
  }
  const bool is_mounting = name.error_class == ErrorClass::component && (text == "t" || text == "w");
  if (!is_mounting && !is_element(text)) return std::nullopt;
  name.axis = text;
  return name;
}

std::string to_string(const ErrorName& name) {
  std::string text;
  switch (name.error_class) {
    case ErrorClass::component:
    case ErrorClass::location:
      text += 'E';
      break;
    case ErrorClass::thermal:
      text += 'T';
      break;
    case ErrorClass::dynamic:
      text += 'D';
      break;
  }
  text += kDirections[static_cast<std::size_t>(std::clamp(name.direction, 0, 5))];
  if (name.error_class == ErrorClass::location) text += '0';
  return text + name.axis;
}

}  // namespace abbe
