// Packets in single precision: commands stay double, what is computed of them and stays small beside them
// does not. See kernel_code.h for what may stand here.
#pragma once

#include "abbe/kernel/kernel_code.h"

#if defined(ABBE_KERNEL_HAS_SINGLES)

namespace abbe::kernel {
namespace {

constexpr int kSingles = lanes_of<Single>;
/// Half a packet, in double precision.
typedef double Half __attribute__((vector_size(sizeof(Single))));
constexpr int kHalf = kSingles / 2;
typedef float HalfSingle __attribute__((vector_size(sizeof(Single) / 2)));

/// All commands of a packet, which are neighbours in memory.
struct Commands {
  Half first, second;
};
// Register by register: copies in smaller pieces would have to reach memory before they are read as one.
inline Commands load_commands(const double* q) {
  Commands commands;
  __builtin_memcpy(&commands.first, q, sizeof(Half));
  __builtin_memcpy(&commands.second, q + kHalf, sizeof(Half));
  return commands;
}
inline void store_commands(double* q, const Commands& commands) {
  __builtin_memcpy(q, &commands.first, sizeof(Half));
  __builtin_memcpy(q + kHalf, &commands.second, sizeof(Half));
}
inline Single joined(const HalfSingle& a, const HalfSingle& b) {
#if defined(__AVX512F__)
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#else
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}
inline Single rounded(const Commands& x) {
  return joined(__builtin_convertvector(x.first, HalfSingle), __builtin_convertvector(x.second, HalfSingle));
}
/// q := q + dq
inline void add(Commands& q, const Single& dq) {
#if defined(__AVX512F__)
  const HalfSingle a = __builtin_shufflevector(dq, dq, 0, 1, 2, 3, 4, 5, 6, 7);
  const HalfSingle b = __builtin_shufflevector(dq, dq, 8, 9, 10, 11, 12, 13, 14, 15);
#else
  const HalfSingle a = __builtin_shufflevector(dq, dq, 0, 1, 2, 3);
  const HalfSingle b = __builtin_shufflevector(dq, dq, 4, 5, 6, 7);
#endif
  q.first = q.first + __builtin_convertvector(a, Half);
  q.second = q.second + __builtin_convertvector(b, Half);
}

/// As for other packets. Outside of what single precision is good for the packet is `refused`.
template <>
struct State<Single> {
  Single q[kMaxFlatAxes];
  const double* commands[kMaxFlatAxes];  ///< kSingles of them
  const double *tip = nullptr, *axis = nullptr;
  const signed char* approach = nullptr;
  Place* places = nullptr;  ///< kPlaces, by the order of tables in the walk
  unsigned visits = 0;
  bool refused = false;
};

/// Each lane's number of `eight`; the indices are below kWindow.
inline Single chosen(const float* eight, const SingleMask& index) {
#if defined(__AVX512F__)
  return (Single)_mm512_permutexvar_ps((__m512i)index, _mm512_castps256_ps512(_mm256_load_ps(eight)));
#else
  return (Single)_mm256_permutevar8x32_ps(_mm256_load_ps(eight), (__m256i)index);
#endif
}

/// Positions from the place's zero on, and whether all are in its window.
inline bool are_in_window(const Place& place, const double* q, Single& x) {
  const Commands commands = load_commands(q);
  x = rounded({commands.first - place.base, commands.second - place.base});
  return lanes_outside(x, place.window[kBeginRow], place.window[kEndNumber]) == 0;
}

/// The window of the first and the last pose.
[[gnu::noinline]] inline void find_window(const FlatTable& table, const double* q, Place& place) {
  const double turns =
      table.period > 0 ? table.period * __builtin_floor((q[0] - table.period_lo) / table.period) : 0.0;
  const std::uint32_t first = segment_of(table, q[0] - turns),
                      last = segment_of(table, q[kSingles - 1] - turns);
  const std::uint32_t window = (first < last ? first : last) / kWindowStep;
  place = {&table, table.windows + window * table.window_size, table.knots[window * kWindowStep] + turns};
}

/// Each lane's segment in the window.
inline SingleMask segments_of(const float* window, const Single& x) {
  const float per_unit = window[kPerUnitNumber];
  if (per_unit > 0) return __builtin_convertvector(x * per_unit, SingleMask);
  SingleMask index = {};
  for (std::uint32_t k = 1; k < kWindow; ++k) index -= x >= window[kBeginRow + k];
  return index;
}

/// As in other packets, from a window of the table.
[[gnu::always_inline]] inline void read_table(const FlatTable& table, State<Single>& state, Single* six) {
  const double* const q = state.commands[table.axis];
  Place& place = state.places[state.visits++ % kPlaces];
  Single x;
  if (place.table != &table || !are_in_window(place, q, x)) {
    find_window(table, q, place);
    if (!are_in_window(place, q, x)) {
      state.refused = true;
      for (int k = 0; k < kComponents; ++k) six[k] = Single{};
      return;
    }
  }
  const SingleMask index = segments_of(place.window, x);
  const Single t = x - chosen(place.window + kOriginRow, index);
  const float* numbers = place.window + kFirstCoefficient;
  for (int k = 0; k < kComponents; ++k) six[k] = chosen(numbers + k * static_cast<int>(kWindow), index);
  for (std::uint32_t power = 1; power < table.row_count; ++power) {
    numbers += kComponents * kWindow;
    for (int k = 0; k < kComponents; ++k)
      six[k] = six[k] * t + chosen(numbers + k * static_cast<int>(kWindow), index);
  }
}

/// Sine and cosine to 2e-7: reduced in double precision, then the polynomials of Cephes (sinf.c) on [-pi/4,
/// pi/4]. Positions beyond 1e5 are refused by correct_singles.
inline void sine_and_cosine(const State<Single>& state, int axis, Single& s, Single& c) {
  constexpr double kTwoOverPi = 6.36619772367581382433e-01, kHalfPi = 1.57079632679489661923;
  const Commands q = load_commands(state.commands[axis]);
  const Commands n = {(q.first * kTwoOverPi + kRoundingShift) - kRoundingShift,
                      (q.second * kTwoOverPi + kRoundingShift) - kRoundingShift};
  const Single r = rounded({q.first - n.first * kHalfPi, q.second - n.second * kHalfPi});
  const SingleMask turns = __builtin_convertvector(rounded(n), SingleMask);
  const Single z = r * r;
  const Single ps = r + r * z * (-1.6666654611e-1f + z * (8.3321608736e-3f + z * -1.9515295891e-4f));
  const Single pc =
      1.0f - 0.5f * z +
      z * z * (4.166664568298827e-2f + z * (-1.388731625493765e-3f + z * 2.443315711809948e-5f));
  const SingleMask odd = (turns & 1) != 0;
  const SingleMask minus_s = (turns & 2) << 30, minus_c = ((turns + 1) & 2) << 30;  // the sign bit
  const SingleMask a = (SingleMask)ps, b = (SingleMask)pc;
  s = (Single)(((odd & b) | (~odd & a)) ^ minus_s);
  c = (Single)(((odd & a) | (~odd & b)) ^ minus_c);
}

}  // namespace
}  // namespace abbe::kernel

#endif
