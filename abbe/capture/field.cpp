#include "abbe/capture/field.h"

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

}  // namespace

Field make_field(const PdoObject& object, std::size_t column, std::uint64_t bit) {
  Field field;
  field.kind = kind_of(object, bit % 8 == 0);
  field.column = column;
  field.byte = static_cast<std::size_t>(bit / 8);
  field.bit = static_cast<std::size_t>(bit);
  field.bits = object.bits;
  field.scale = object.scale;
  return field;
}

}  // namespace abbe
