#pragma once

#include <array>
#include <limits>
#include <memory>

#include "abbe/chain/plan.h"

namespace abbe {

/// Positions of all moving axes at the ends of a move along which every axis goes evenly, mm and rad: as the
/// control means it, and as the machine does it.
struct EvenMove {
  std::array<double, kMaxAxes> meant_from{}, meant_to{}, done_from{}, done_to{};
};

/// How far the axes go in a move, or at most in each of several, mm and rad.
struct MoveExtent {
  struct Axis {
    double lo = 0, hi = 0;  ///< of what is done
    double way = 0;         ///< |done_to - done_from|
    double change = 0;      ///< |(done - meant) at the end - at the start|
    double offset = 0;      ///< |done - meant| at either end
  };
  std::array<Axis, kMaxAxes> axes{};
};
[[nodiscard]] MoveExtent extent_of(const EvenMove& move);

/// Moves one after the other, the positions of each axis side by side: move i goes from place i to i + 1.
struct MoveRun {
  static constexpr std::size_t kMost = 16;
  using Row = std::array<double, kMost + 1>;
  std::array<Row, kMaxAxes> meant{}, done{};

  /// Of the moves first .. end - 1 (first < end <= kMost), those of `axis_count` axes.
  [[nodiscard]] MoveExtent extent(std::size_t first, std::size_t end, std::size_t axis_count) const;
};

/// How far inside a move the tip may be from where it is meant to be, beyond what is so at its ends. With
/// N the nominal and N + E the actual tip, q what is meant and x what is done, both even in t,
///
///   m(t) = N(x) + E(x) - N(q),   |m(t) - ((1-t) m(0) + t m(1))| <= max |m''| / 8 + jumps / 4
///
/// is a bound, not a sample:
///
///   |(N(x) - N(q))''| <= w' (2 w L + 2 v) + 2 v' w + o_w (w^2 L + 2 w v) + o_v w^2
///   |E(x)''| <= w^2 (D + 4 e L) + 4 e w v
///               + sum over axes of s^2 (d2 + e2 L) + 2 s (w (d1 + e1 L) + e1 (w L + v))
///
/// s, w, v    way of an axis; of all rotary, all linear ones together
/// w' v'      the same of the change of x - q, and o_w, o_v of its largest value
/// d e d1 ..  largest values and derivatives of the functions (table_bounds.h), e their rotations; D of all d
/// L          chain_length of table_bounds.h
///
/// For the direction of the tool, rad, the same without positions: L = 1, v = d = 0.
/// units    mm, rad
/// errors   infinite where nothing is known: functions that are not tabulated, steps, a control that
///          reckons with a chain of its own, a rotary axis without travels far from zero
/// laws     TurningBend.MovesBendNoMoreThanTheBound, TurningBend.WhatIsNotTabulatedIsNotKnown,
///          TurningBend.TheBoundOfSeveralMovesIsOneOfEach
/// cost     make: once per tool; bound: about 20 ns, no allocation
class TurningBend {
 public:
  TurningBend(const Plan& plan, const Tool& tool);
  ~TurningBend();
  TurningBend(TurningBend&&) noexcept;
  TurningBend& operator=(TurningBend&&) noexcept;

  struct Bound {
    double position = std::numeric_limits<double>::infinity();   ///< mm
    double direction = std::numeric_limits<double>::infinity();  ///< rad
  };
  [[nodiscard]] Bound bound(const MoveExtent& extent) const;
  /// e: the rotations of all errors together, rad; infinite where nothing is known.
  [[nodiscard]] double rotations() const;
  [[nodiscard]] Bound bound(const EvenMove& move) const { return bound(extent_of(move)); }

 private:
  struct Constants;
  std::unique_ptr<const Constants> constants_;  ///< null: nothing is known
};

}  // namespace abbe
