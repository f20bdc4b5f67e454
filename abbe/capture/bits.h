#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace abbe {

/// `bits` (1 to 64) from bit `at` on, least significant first; the bytes must reach that far.
[[nodiscard]] inline std::uint64_t load_bits(std::span<const std::uint8_t> bytes, std::size_t at, int bits) {
  std::uint64_t value = 0;
  for (int done = 0; done < bits;) {
    const std::size_t place = at + static_cast<std::size_t>(done), shift = place % 8;
    const int take = std::min(bits - done, 8 - static_cast<int>(shift));
    const std::uint64_t part = (bytes[place / 8] >> shift) & ((1U << take) - 1U);
    value |= part << done;
    done += take;
  }
  return value;
}

/// Puts the lowest `bits` of value there; other bits stay.
inline void store_bits(std::span<std::uint8_t> bytes, std::size_t at, int bits, std::uint64_t value) {
  for (int done = 0; done < bits;) {
    const std::size_t place = at + static_cast<std::size_t>(done), shift = place % 8;
    const int take = std::min(bits - done, 8 - static_cast<int>(shift));
    const auto mask = static_cast<std::uint8_t>(((1U << take) - 1U) << shift);
    const auto part = static_cast<std::uint8_t>((value >> done) << shift);
    bytes[place / 8] = static_cast<std::uint8_t>((bytes[place / 8] & ~mask) | (part & mask));
    done += take;
  }
}

/// The lowest `bits` of raw as a two's complement number.
[[nodiscard]] inline std::int64_t sign_extended(std::uint64_t raw, int bits) {
  const int spare = 64 - bits;
  return static_cast<std::int64_t>(raw << spare) >> spare;
}

}  // namespace abbe
