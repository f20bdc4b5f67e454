#pragma once

#include <optional>
#include <variant>

#include "abbe/machine/machine.h"

namespace abbe {

/// Temperature at which lengths of workpieces are stated (ISO 1), degC.
inline constexpr double kStandardTemperature = 20;

/// A workpiece that is warmer or colder than its drawing.
struct WorkpieceExpansion {
  double temperature = kStandardTemperature;  ///< degC
  double coefficient = 0;                     ///< 1/K
  /// s = alpha (T - 20): lengths of the warm part are 1 + s times those at 20 degC.
  [[nodiscard]] double strain() const { return coefficient * (temperature - kStandardTemperature); }
};

/// The machine with the workpiece's expansion as errors, so that everything that knows errors knows it. What
/// is machined at p of a warm part is at p / (1 + s) when it has cooled, so to first order in s
///
///   deviation(p) = -s p,   p = tip in workpiece axes from the workpiece's origin
///
/// and a correction moves the tip by +s p. As every translation of the chain shrinks alike, each body gets
///
///   work branch   d_i = -s (q_i u_i [linear] + o_next - o_i)      (next: the body it carries, then the
///   workpiece) tool branch   d_i = -s q_i u_i;   tool   d_t = -s (tip at home - o_first work body)
///
/// errors   text: why this chain cannot (a rotary axis carries the tool, whose length is not the machine's to
/// scale;
///          an order without static errors, or with those of a rotary axis before its motion)
/// laws     DeviationIsProportionalToThePlace, WarmPartIsCutLarger
/// cost     a few terms per body
[[nodiscard]] std::variant<Machine, std::string> with_expansion(const Machine& machine,
                                                                const WorkpieceExpansion& expansion);

}  // namespace abbe
