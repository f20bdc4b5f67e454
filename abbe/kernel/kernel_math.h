// Packets, vectors of packets, sines of packets. See kernel_code.h for what may stand here.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>  // always inlined: no symbols of their own
#endif

#include "abbe/kernel/kernel.h"

namespace abbe::kernel {
namespace {

#if defined(__AVX512F__)
constexpr std::size_t kNativeLanes = 8;
#elif defined(__AVX2__)
constexpr std::size_t kNativeLanes = 4;
#else
constexpr std::size_t kNativeLanes = 2;
#endif
typedef double Native __attribute__((vector_size(8 * kNativeLanes)));
/// Poses side by side in a batch.
typedef Native Packet;
/// Registers that hold the six components of a row.
constexpr std::size_t kNatives = (kComponents + kNativeLanes - 1) / kNativeLanes;

/// What a lane of V is.
template <class V>
struct NumberOf {
  using type = double;
};
#if defined(__AVX2__)
#define ABBE_KERNEL_HAS_SINGLES
/// Poses side by side in single precision: one register of them.
typedef float Single __attribute__((vector_size(8 * kNativeLanes)));
template <>
struct NumberOf<Single> {
  using type = float;
};
#endif
template <class V>
using Number = typename NumberOf<V>::type;

template <class V>
constexpr int lanes_of = static_cast<int>(sizeof(V) / sizeof(Number<V>));

template <class V>
inline Number<V> lane(const V& v, int i) {
  if constexpr (lanes_of<V> == 1) {
    return v;
  } else {
    return v[i];
  }
}
template <class V>
inline void set_lane(V& v, int i, Number<V> x) {
  if constexpr (lanes_of<V> == 1) {
    v = x;
  } else {
    v[i] = x;
  }
}

/// x in every lane. The difference is no work: x - 0 is x for every number.
template <class V>
inline V all(Number<V> x) {
  return x - V{};
}

/// The integers of a comparison: all bits of a lane set where it holds.
template <class V>
struct MaskOf {
  typedef long long type __attribute__((vector_size(sizeof(V))));
};
#if defined(ABBE_KERNEL_HAS_SINGLES)
typedef int SingleMask __attribute__((vector_size(sizeof(Single))));
template <>
struct MaskOf<Single> {
  typedef SingleMask type;
};

/// Bit i: lane i of a comparison holds.
inline unsigned bits_of(const SingleMask& mask) {
#if defined(__AVX512F__)
  return _mm512_movepi32_mask((__m512i)mask);
#else
  return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask));
#endif
}
#endif
template <class M>
inline unsigned bits_of(const M& mask) {
#if defined(__AVX512F__)
  if constexpr (sizeof(M) == 64) return _mm512_movepi64_mask((__m512i)mask);
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(M) == 32) return static_cast<unsigned>(_mm256_movemask_pd((__m256d)mask));
#endif
#if defined(__SSE2__)
  if constexpr (sizeof(M) == 16) return static_cast<unsigned>(_mm_movemask_pd((__m128d)mask));
#endif
  unsigned bits = 0;
  for (std::size_t i = 0; i < sizeof(M) / sizeof(double); ++i) bits |= (mask[i] != 0 ? 1u : 0u) << i;
  return bits;
}

template <class V>
constexpr unsigned kAllLanes = (1u << lanes_of<V>)-1;

/// Bit i: lane i is not in [lo, hi] (or no number).
template <class V>
inline unsigned lanes_outside(const V& v, Number<V> lo, Number<V> hi) {
  if constexpr (lanes_of<V> == 1) {
    return v >= lo && v <= hi ? 0u : 1u;
  } else {
    return ~bits_of(static_cast<typename MaskOf<V>::type>((v >= lo) & (v <= hi))) & kAllLanes<V>;
  }
}
/// Bit i: |lane i| < limit (or no number).
template <class V>
inline unsigned lanes_within(const V& v, Number<V> limit) {
  if constexpr (lanes_of<V> == 1) {
    return v >= limit || v <= -limit ? 0u : 1u;
  } else {
    return ~bits_of(static_cast<typename MaskOf<V>::type>((v >= limit) | (v <= -limit))) & kAllLanes<V>;
  }
}

#if defined(__AVX512F__)
// Comparisons of singles stay in mask registers.
inline unsigned lanes_outside(const Single& v, float lo, float hi) {
  const __m512 x = (__m512)v;
  const unsigned above = _mm512_cmp_ps_mask(x, (__m512)all<Single>(lo), _CMP_GE_OQ);
  return ~(above & _mm512_cmp_ps_mask(x, (__m512)all<Single>(hi), _CMP_LE_OQ)) & kAllLanes<Single>;
}
#endif

template <class V>
inline V root(V v) {
#if defined(__AVX512F__)
  if constexpr (sizeof(V) == 64) return (V)_mm512_maskz_sqrt_pd(0xff, (__m512d)v);
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(V) == 32) return (V)_mm256_sqrt_pd((__m256d)v);
#endif
#if defined(__SSE2__)
  if constexpr (sizeof(V) == 16) return (V)_mm_sqrt_pd((__m128d)v);
#endif
  for (int i = 0; i < lanes_of<V>; ++i) set_lane(v, i, __builtin_sqrt(lane(v, i)));
  return v;
}
#if defined(ABBE_KERNEL_HAS_SINGLES)
inline Single root(const Single& v) {
#if defined(__AVX512F__)
  return (Single)_mm512_maskz_sqrt_ps(0xffff, (__m512)v);
#else
  return (Single)_mm256_sqrt_ps((__m256)v);
#endif
}
#endif

template <class V>
struct Triple {
  V x, y, z;  // not set: arrays of them are large
  friend Triple operator+(const Triple& a, const Triple& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Triple operator-(const Triple& a, const Triple& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Triple operator-(const Triple& a) { return {-a.x, -a.y, -a.z}; }
  friend Triple operator*(const Triple& a, V s) { return {a.x * s, a.y * s, a.z * s}; }
};
template <class V>
inline V dot(const Triple<V>& a, const Triple<V>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class V>
inline Triple<V> cross(const Triple<V>& a, const Triple<V>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class V, class From>
inline Triple<V> broadcast(const From* v) {
  using To = Number<V>;
  return {all<V>(static_cast<To>(v[0])), all<V>(static_cast<To>(v[1])), all<V>(static_cast<To>(v[2]))};
}

/// Rounds to the nearest integer, |x| < 2^51.
constexpr double kRoundingShift = 6755399441055744.0;  // 1.5 * 2^52

template <class V>
inline V wrapped(V x, double lo, double period) {
  for (int i = 0; i < lanes_of<V>; ++i) {
    const double turns = __builtin_floor((lane(x, i) - lo) / period);
    if (turns != 0 && turns - turns == 0) set_lane(x, i, lane(x, i) - turns * period);
  }
  return x;
}

/// Sine and cosine: three-part reduction by multiples of pi/2, then the Taylor-like minimax polynomials
/// of fdlibm (k_sin.c, k_cos.c) on [-pi/4, pi/4]. Error below 1.5 units in the last place for
/// |q| < 1e5; larger ones lane by lane.
template <class V>
inline void sine_and_cosine(V q, V& s, V& c) {
  if constexpr (lanes_of<V> == 1) {
    s = __builtin_sin(q);
    c = __builtin_cos(q);
    return;
  } else {
    if (lanes_outside(q, -1e5, 1e5) != 0) {
      for (int i = 0; i < lanes_of<V>; ++i) {
        set_lane(s, i, __builtin_sin(lane(q, i)));
        set_lane(c, i, __builtin_cos(lane(q, i)));
      }
      return;
    }
    using Mask = typename MaskOf<V>::type;
    constexpr double kTwoOverPi = 6.36619772367581382433e-01;
    // pi/2 in three parts of 33 bits
    constexpr double kPart1 = 1.57079632673412561417e+00, kPart2 = 6.07710050630396597660e-11,
                     kPart3 = 2.02226624871116645580e-21;
    const V shifted = q * kTwoOverPi + kRoundingShift;
    Mask bits;
    __builtin_memcpy(&bits, &shifted, sizeof bits);
    const V n = shifted - kRoundingShift;
    const V r = ((q - n * kPart1) - n * kPart2) - n * kPart3;
    const V z = r * r;
    const V ps =
        r + r * z *
                (-1.66666666666666324348e-01 +
                 z * (8.33333333332248946124e-03 +
                      z * (-1.98412698298579493134e-04 +
                           z * (2.75573137070700676789e-06 +
                                z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
    const V pc = 1.0 - 0.5 * z +
                 z * z *
                     (4.16666666666666019037e-02 +
                      z * (-1.38888888888741095749e-03 +
                           z * (2.48015872894767294178e-05 +
                                z * (-2.75573143513906633035e-07 +
                                     z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
    // n mod 4: 0 (s, c), 1 (c, -s), 2 (-s, -c), 3 (-c, s)
    const Mask odd = (bits & 1) != 0;
    const Mask minus_s = (bits & 2) << 62, minus_c = ((bits + 1) & 2) << 62;  // the sign bit
    Mask a, b;
    __builtin_memcpy(&a, &ps, sizeof a);
    __builtin_memcpy(&b, &pc, sizeof b);
    const Mask sine = ((odd & b) | (~odd & a)) ^ minus_s, cosine = ((odd & a) | (~odd & b)) ^ minus_c;
    __builtin_memcpy(&s, &sine, sizeof s);
    __builtin_memcpy(&c, &cosine, sizeof c);
  }
}

/// s = sin t / t, k = (1 - cos t) / t^2 of t2 = t^2. Below 0.01 rad the series are exact to 1e-16.
template <class V>
inline void rotation_coefficients(V t2, V& s, V& k) {
  if (lanes_outside(t2, 0.0, 1e-4) == 0) {
    s = 1.0 - t2 * (1.0 / 6 - t2 * (1.0 / 120));
    k = 0.5 - t2 * (1.0 / 24 - t2 * (1.0 / 720));
    return;
  }
  for (int i = 0; i < lanes_of<V>; ++i) {
    const double x = lane(t2, i);
    if (x < 1e-4) {
      set_lane(s, i, 1.0 - x * (1.0 / 6 - x * (1.0 / 120)));
      set_lane(k, i, 0.5 - x * (1.0 / 24 - x * (1.0 / 720)));
    } else {
      const double t = __builtin_sqrt(x), half = __builtin_sin(0.5 * t);
      set_lane(s, i, __builtin_sin(t) / t);
      set_lane(k, i, 2 * half * half / x);
    }
  }
}

}  // namespace
}  // namespace abbe::kernel
