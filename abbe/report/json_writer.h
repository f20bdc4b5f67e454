#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/linear_algebra.h"

namespace abbe {

/// Writes JSON text from front to back, so that results of any length stream in constant memory:
/// take() hands over what is complete so far.
///
/// Members appear in the order of the calls; a container is laid out over lines, or in one line
/// with everything inside it. Numbers are the shortest text that reads back to the same double (17
/// significant digits at most).
///
/// errors   a number that is not finite is written as null (JSON has no such numbers); bytes that are
///          not UTF-8 become U+FFFD
/// laws     WhatIsWrittenReadsBack, NumbersReadBackBitEqual
class JsonWriter {
 public:
  enum class Layout { lines, one_line };

  JsonWriter& begin_object(Layout layout = Layout::lines) { return begin('{', layout); }
  JsonWriter& begin_array(Layout layout = Layout::lines) { return begin('[', layout); }
  /// Closes the innermost open container.
  JsonWriter& end();
  /// The name of the next value; only inside an object.
  JsonWriter& key(std::string_view name);

  JsonWriter& value(double number);
  JsonWriter& value(std::uint64_t number);
  JsonWriter& value(int number);
  JsonWriter& value(bool truth);
  JsonWriter& value(std::string_view text);
  JsonWriter& value(const char* text) { return value(std::string_view(text)); }
  JsonWriter& value(const Vec3& v) { return value(std::span<const double>(v.data(), 3)); }
  JsonWriter& value(std::span<const double> numbers);
  JsonWriter& value(const std::vector<std::string>& texts);
  JsonWriter& null();

  template <class T>
  JsonWriter& member(std::string_view name, const T& v) {
    key(name);
    return value(v);
  }

  /// Bytes written so far, and no longer held here.
  [[nodiscard]] std::string take();
  [[nodiscard]] std::size_t pending() const { return text_.size(); }

 private:
  struct Open {
    char close;
    Layout layout;
    bool empty;
  };
  JsonWriter& begin(char open, Layout layout);
  void separate();
  void quote(std::string_view text);

  std::string text_;
  std::vector<Open> open_;
  bool after_key_ = false;
};

}  // namespace abbe
