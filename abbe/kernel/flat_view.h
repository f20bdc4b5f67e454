#pragma once

// Plain data: read by code that is compiled for one instruction set.

#include <cstddef>
#include <cstdint>

#include "abbe/chain/axis_table.h"

namespace abbe::kernel {

/// Most moving axes a kernel knows: three linear and two rotary ones, and locked ones.
inline constexpr int kMaxFlatAxes = 16;
/// Doubles per row of coefficients: six components and two zeros, one cache line.
inline constexpr std::size_t kRow = 8;
/// Segments of a window (FlatTable::windows), and how many segments the next window begins later.
inline constexpr std::uint32_t kWindow = 8, kWindowStep = 4;

// A window of a table in single precision: kWindow neighbouring segments, each number of all of them side by
// side, so that one permutation gives every pose the number of its own segment. Positions x count from the
// origin of the window's first segment and are in the window if begin[0] <= x <= end. It is an array of rows
// of kWindow numbers:
//   begin     of the segments; infinite where there is none, all if the window is not for use
//   origin    of their polynomials
//   limits    end; segments per unit if they are equally wide (x is in number x * per_unit), else 0; no more
//   then      the coefficients, highest power first, of each power one row per component
inline constexpr std::size_t kBeginRow = 0, kOriginRow = kWindow, kEndNumber = 2 * kWindow,
                             kPerUnitNumber = kEndNumber + 1, kFirstCoefficient = 3 * kWindow;

/// abbe::AxisTable with its numbers at hand.
struct FlatTable {
  const double* knots = nullptr;  ///< `segments` origins
  const double* rows = nullptr;   ///< kRow doubles each, 64-byte aligned
  const std::uint32_t* buckets = nullptr;
  const Wave* waves = nullptr;
  const float* windows = nullptr;  ///< window_size floats each, on 32-byte boundaries
  std::size_t window_size = 0;
  double bucket_lo = 0, buckets_per_unit = 0, most_bucket = 0;
  double lo = 0, hi = 0;  ///< infinite if nothing is held
  double waves_lo = 0, waves_hi = 0;
  double period = 0, period_lo = 0;
  std::uint32_t row_count = 1, segments = 1, wave_count = 0;
  int axis = 0;
  std::int8_t direction = 0, direction_axis = 0;
};

/// Where a walk found a table's window last time: the next packet is mostly there, too.
struct Place {
  const FlatTable* table = nullptr;
  const float* window = nullptr;
  double base = 0;  ///< position of its zero
};
inline constexpr unsigned kPlaces = 32;  ///< tables of a walk that are remembered

struct FlatGroup {
  alignas(64) double constant[kRow] = {};
  double lever[3] = {0, 0, 0};
  bool has_lever = false, is_rotary = false, rotates = false;
  const FlatTable* tables = nullptr;
  std::uint32_t table_count = 0;
};

/// What a step of the walk from the tool to the workpiece does (see abbe::Op).
struct FlatStep {
  /// As in abbe::Op, and constant twists: displacement u, rotation a[0..2], signs included.
  enum class Kind : std::uint8_t { tip, slide, turn, affine, shift, rigid, linear, twist, fixed_twist };
  enum class About : std::uint8_t { x, y, z, other };  ///< the axis of a slide or turn, up to its sign
  Kind kind = Kind::tip;
  About about = About::other;
  bool inverse = false;
  bool moves_on = false;  ///< t is not zero
  std::uint8_t part = 0;  ///< 0 all, 1 along, 2 across
  std::int8_t axis = -1;
  std::int16_t group = -1;
  const FlatTable* table = nullptr;  ///< the factor is this table and nothing else: no lever, no part
};

/// A step with its constants at hand, in double or single precision.
template <class Number>
struct FlatOpOf : FlatStep {
  Number u[3] = {0, 0, 1};
  Number t[3] = {0, 0, 0};
  Number a[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< affine: rows
};
using FlatOp = FlatOpOf<double>;

/// A compiled machine as pointers: what abbe::Plan holds, laid out for kernels. Owned by FlatPlan.
struct FlatView {
  const FlatOp *actual = nullptr, *first_order = nullptr;
  const FlatOpOf<float>* single = nullptr;  ///< the first-order walk in single precision
  std::uint32_t actual_count = 0, first_order_count = 0, single_count = 0;
  const FlatGroup* groups = nullptr;
  int axis_count = 0;
  std::uint32_t rotary = 0;  ///< bit i: moving axis i is rotary
};

}  // namespace abbe::kernel
