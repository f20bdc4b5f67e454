#include "abbe/capture/field.h"

#include <algorithm>
#include <type_traits>

#include "abbe/capture/bits.h"
#include "abbe/capture/frame.h"

namespace abbe {
namespace {

Field::Kind kind_of(const PdoObject& object, bool aligned) {
  using Kind = Field::Kind;
  const bool with_sign = object.type == PdoType::signed_integer;
  if (object.type == PdoType::real && aligned) return object.bits == 32 ? Kind::f32 : Kind::f64;
  if (aligned) {
    switch (object.bits) {
      case 8:
        return with_sign ? Kind::i8 : Kind::u8;
      case 16:
        return with_sign ? Kind::i16 : Kind::u16;
      case 32:
        return with_sign ? Kind::i32 : Kind::u32;
      case 64:
        return with_sign ? Kind::i64 : Kind::u64;
      default:
        break;
    }
  }
  return with_sign ? Kind::signed_bits : Kind::bits;
}

double finite(double value) { return value - value == 0 ? value : 0; }

/// Reads fields as long as they are of the kind of the first; returns the first that is not.
template <class Raw>
const Field* read_run(const Field* f, const Field* end, const std::uint8_t* data, std::size_t row) {
  const Field::Kind kind = f->kind;
  do {
    const double value = static_cast<double>(load_little<Raw>(data + f->bit / 8)) * f->scale;
    f->out[row] = std::is_floating_point_v<Raw> ? finite(value) : value;
  } while (++f != end && f->kind == kind);
  return f;
}

double read_bits(const Field& f, std::span<const std::uint8_t> data) {
  const std::uint64_t raw = load_bits(data, f.bit, f.bits);
  if (f.kind == Field::Kind::signed_bits) return static_cast<double>(sign_extended(raw, f.bits)) * f.scale;
  return static_cast<double>(raw) * f.scale;
}

}  // namespace

Field make_field(const PdoObject& object, std::uint64_t bit, double* out) {
  Field field;
  field.kind = kind_of(object, bit % 8 == 0);
  field.bits = object.bits;
  field.bit = static_cast<std::size_t>(bit);
  field.scale = object.scale;
  field.out = out;
  return field;
}

void sort_by_kind(std::span<Field> fields) {
  std::stable_sort(fields.begin(), fields.end(),
                   [](const Field& a, const Field& b) { return a.kind < b.kind; });
}

void read_fields(std::span<const Field> fields, std::span<const std::uint8_t> data, std::size_t row) {
  using Kind = Field::Kind;
  const std::uint8_t* p = data.data();
  const Field *f = fields.data(), *end = f + fields.size();
  while (f != end) {
    switch (f->kind) {
      case Kind::i8:
        f = read_run<std::int8_t>(f, end, p, row);
        break;
      case Kind::u8:
        f = read_run<std::uint8_t>(f, end, p, row);
        break;
      case Kind::i16:
        f = read_run<std::int16_t>(f, end, p, row);
        break;
      case Kind::u16:
        f = read_run<std::uint16_t>(f, end, p, row);
        break;
      case Kind::i32:
        f = read_run<std::int32_t>(f, end, p, row);
        break;
      case Kind::u32:
        f = read_run<std::uint32_t>(f, end, p, row);
        break;
      case Kind::i64:
        f = read_run<std::int64_t>(f, end, p, row);
        break;
      case Kind::u64:
        f = read_run<std::uint64_t>(f, end, p, row);
        break;
      case Kind::f32:
        f = read_run<float>(f, end, p, row);
        break;
      case Kind::f64:
        f = read_run<double>(f, end, p, row);
        break;
      case Kind::bits:
      case Kind::signed_bits:
        f->out[row] = read_bits(*f, data);
        ++f;
        break;
    }
  }
}

}  // namespace abbe
