#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "abbe/capture/process_map.h"

namespace abbe {

/// A signal's place in the data of one process datagram, and where its values go.
struct Field {
  enum class Kind : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64, bits, signed_bits };
  Kind kind = Kind::bits;
  int bits = 0;
  std::size_t bit = 0;  ///< where it begins in the data
  double scale = 1;
  double* out = nullptr;  ///< its value in row r goes to out[r]
};

/// `bit`: where the object begins in the data.
[[nodiscard]] Field make_field(const PdoObject& object, std::uint64_t bit, double* out);

/// Brings fields of one kind together, so that they are read in runs.
void sort_by_kind(std::span<Field> fields);

/// value = raw * scale, of every field. A real number that is none reads as 0.
void read_fields(std::span<const Field> fields, std::span<const std::uint8_t> data, std::size_t row);

}  // namespace abbe
