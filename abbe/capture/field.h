#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "abbe/capture/bits.h"
#include "abbe/capture/frame.h"
#include "abbe/capture/process_map.h"

namespace abbe {

/// A column's place in the data of one process datagram, ready to be read.
struct Field {
  enum class Kind : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64, bits, signed_bits };
  Kind kind = Kind::bits;
  std::size_t column = 0;
  std::size_t byte = 0, bit = 0;
  int bits = 0;
  double scale = 1;
};

/// `bit`: where the object begins in the data.
[[nodiscard]] Field make_field(const PdoObject& object, std::size_t column, std::uint64_t bit);

/// value = raw * scale. A real number that is none reads as 0.
[[nodiscard]] inline double read_field(const Field& f, std::span<const std::uint8_t> data) {
  const std::uint8_t* p = data.data() + f.byte;
  const auto scaled = [&f](auto raw) { return static_cast<double>(raw) * f.scale; };
  switch (f.kind) {
    case Field::Kind::i32:
      return scaled(load_little<std::int32_t>(p));
    case Field::Kind::u16:
      return scaled(load_little<std::uint16_t>(p));
    case Field::Kind::i16:
      return scaled(load_little<std::int16_t>(p));
    case Field::Kind::u32:
      return scaled(load_little<std::uint32_t>(p));
    case Field::Kind::i8:
      return scaled(static_cast<std::int8_t>(*p));
    case Field::Kind::u8:
      return scaled(*p);
    case Field::Kind::i64:
      return scaled(load_little<std::int64_t>(p));
    case Field::Kind::u64:
      return scaled(load_little<std::uint64_t>(p));
    case Field::Kind::f32: {
      const double value = scaled(load_little<float>(p));
      return value - value == 0 ? value : 0;
    }
    case Field::Kind::f64: {
      const double value = scaled(load_little<double>(p));
      return value - value == 0 ? value : 0;
    }
    case Field::Kind::signed_bits:
      return scaled(sign_extended(load_bits(data, f.bit, f.bits), f.bits));
    case Field::Kind::bits:
      break;
  }
  return scaled(load_bits(data, f.bit, f.bits));
}

}  // namespace abbe
