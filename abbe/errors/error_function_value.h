#pragma once

// The definition of ErrorFunction::value; included by error_function.h.

#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "abbe/errors/error_function.h"

namespace abbe {

namespace error_function_detail {

inline constexpr std::size_t kLinearRecord = 3;  // x, value, slope
inline constexpr std::size_t kCubicRecord = 5;   // x and the coefficients of 1, t, t^2, t^3
inline constexpr std::size_t kMaxGridVariables = 4;

/// The number that decides about segments and ends.
template <class T>
[[nodiscard]] inline double value_part(const T& x) {
  if constexpr (std::is_arithmetic_v<T>) {
    return static_cast<double>(x);
  } else if constexpr (requires { x.a; }) {
    return static_cast<double>(x.a);
  } else {
    return static_cast<double>(x.value());
  }
}

/// v held in [lo, hi]. A value that is no number is held, too: no index is ever made of it.
template <class T>
[[nodiscard]] inline T held(const T& v, double lo, double hi, bool* outside) {
  const double x = value_part(v);
  if (x >= lo && x <= hi) return v;
  if (outside != nullptr) *outside = true;
  return T(x > hi ? hi : lo);
}

/// v moved by whole periods into [first, first + period).
template <class T>
[[nodiscard]] inline T wrapped(const T& v, double first, double period) {
  const double x = value_part(v);
  if (x >= first && x < first + period) return v;
  if (!std::isfinite(x)) return T(first);
  const double turns = std::floor((x - first) / period);
  const double reduced = x - turns * period;
  // What rounding moved onto an end is `first`; so is any x too large to have a place in a period.
  if (!(reduced >= first && reduced < first + period)) return T(v - T(x)) + T(first);
  return v - T(turns * period);
}

/// The record that holds x: the last one whose position (its first number) is not above x, or 0.
[[nodiscard]] inline std::size_t segment(const double* records, std::size_t stride, std::size_t count,
                                         double x) {
  std::size_t base = 0;
  for (std::size_t left = count; left > 1;) {
    const std::size_t half = left / 2;
    base = records[(base + half) * stride] <= x ? base + half : base;
    left -= half;
  }
  return base;
}

/// The same on equally spaced positions, for x between the first and the last one.
[[nodiscard]] inline std::size_t uniform_segment(const double* records, std::size_t stride, std::size_t count,
                                                 double x, double inverse_step) {
  const auto guess = static_cast<std::size_t>(static_cast<std::int64_t>((x - records[0]) * inverse_step));
  const std::size_t i = guess < count - 1 ? guess : count - 1;
  // Rounding may have put us one segment off.
  const std::size_t above = i + 1 < count ? i + 1 : i;
  const std::size_t below = i > 0 ? i - 1 : i;
  if (records[i * stride] > x) return below;
  return records[above * stride] <= x ? above : i;
}

/// Multilinear over the d variables of a grid node.
template <class T>
[[nodiscard]] T grid_value(const double* data, std::size_t d, double reference, const T* variables,
                           bool* outside) {
  std::array<std::size_t, kMaxGridVariables> cell{}, size{};
  std::array<T, kMaxGridVariables> fraction{};
  const double* positions = data + 2 * d;
  for (std::size_t k = 0; k < d; ++k) {
    size[k] = static_cast<std::size_t>(data[k]);
    fraction[k] = T(0.0);
    if (size[k] > 1) {
      T v = variables[static_cast<std::size_t>(data[d + k])];
      if (reference != 0) v = v - T(reference);
      v = held(v, positions[0], positions[size[k] - 1], outside);
      const std::size_t i = segment(positions, 1, size[k] - 1, value_part(v));
      const double step = positions[i + 1] - positions[i];
      fraction[k] = (v - T(positions[i])) / T(step);
      cell[k] = i;
    }
    positions += size[k];
  }

  // The 2^d corners of the cell, the last variable fastest; then one variable after the other is used up.
  const double* const values = positions;
  std::array<T, std::size_t{1} << kMaxGridVariables> corner;
  const std::size_t corners = std::size_t{1} << d;
  for (std::size_t c = 0; c < corners; ++c) {
    std::size_t at = 0;
    for (std::size_t k = 0; k < d; ++k) {
      const bool upper = ((c >> (d - 1 - k)) & 1U) != 0 && size[k] > 1;
      at = at * size[k] + cell[k] + (upper ? 1 : 0);
    }
    corner[c] = T(values[at]);
  }
  for (std::size_t k = d; k-- > 0;) {
    // e = (1 - f) e_lower + f e_upper: equal to the sample at both ends
    for (std::size_t c = 0; c < (std::size_t{1} << k); ++c) {
      corner[c] = (T(1.0) - fraction[k]) * corner[2 * c] + fraction[k] * corner[2 * c + 1];
    }
  }
  return corner[0];
}

}  // namespace error_function_detail

template <class T>
T ErrorFunction::value(const T* variables, const signed char* approach, bool* outside) const {
  if (nodes_.empty()) return T(0.0);
  return node_value<T>(nodes_.back(), variables, approach, outside);
}

template <class T>
T ErrorFunction::node_value(const Node& node, const T* variables, const signed char* approach,
                            bool* outside) const {
  namespace detail = error_function_detail;
  const double* const data = data_.data() + node.data;
  const std::size_t count = node.count;
  const auto child = [&](std::size_t i) {
    return node_value<T>(nodes_[children_[node.first_child + i]], variables, approach, outside);
  };
  // v = variable - reference, held in the domain        docs/theory/error-functions.md (1) and (2)
  const auto argument = [&] {
    T v = variables[node.variable];
    if (node.reference != 0) v = v - T(node.reference);
    return detail::held(v, node.lo, node.hi, outside);
  };
  const auto record = [&](const T& v, std::size_t stride) {
    const double x = detail::value_part(v);
    return data + stride * (node.uniform ? detail::uniform_segment(data, stride, count, x, node.inverse_step)
                                         : detail::segment(data, stride, count, x));
  };

  switch (node.form) {
    case Form::constant:
      return T(data[0]);
    case Form::polynomial: {
      const T v = argument();
      T e = T(data[count - 1]);
      for (std::size_t i = count - 1; i-- > 0;) e = e * v + T(data[i]);
      return e;
    }
    case Form::linear: {
      T v = argument();
      if (node.periodic) v = detail::wrapped(v, data[0], node.period);
      const double* const r = record(v, detail::kLinearRecord);
      return T(r[1]) + T(r[2]) * (v - T(r[0]));
    }
    case Form::cubic: {
      T v = argument();
      if (node.periodic) v = detail::wrapped(v, data[0], node.period);
      const double* const r = record(v, detail::kCubicRecord);
      const T t = v - T(r[0]);
      return T(r[1]) + t * (T(r[2]) + t * (T(r[3]) + t * T(r[4])));
    }
    case Form::sine: {
      using std::sin;
      const T v = argument();
      return T(data[0]) * sin(T(data[1]) * v + T(data[2]));
    }
    case Form::grid:
      return detail::grid_value<T>(data, count, node.reference, variables, outside);
    case Form::sum: {
      T e = T(0.0);
      for (std::size_t i = 0; i < count; ++i) e = e + child(i);
      return e;
    }
    case Form::product: {
      T e = T(1.0);
      for (std::size_t i = 0; i < count; ++i) e = e * child(i);
      return e;
    }
    case Form::directional: {
      const int direction = approach == nullptr ? 0 : approach[node.variable];
      if (direction > 0) return child(0);
      if (direction < 0) return child(1);
      return T(0.5) * (child(0) + child(1));
    }
  }
  return T(0.0);
}

}  // namespace abbe
