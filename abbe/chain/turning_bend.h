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
/// laws     TurningBend.MovesBendNoMoreThanTheBound, TurningBend.WhatIsNotTabulatedIsNotKnown
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
  [[nodiscard]] Bound bound(const EvenMove& move) const;

 private:
  struct Constants;
  std::unique_ptr<const Constants> constants_;  ///< null: nothing is known
};

}  // namespace abbe
