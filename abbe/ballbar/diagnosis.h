#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/core/residuals.h"

namespace abbe {

/// What a machine does to a circle, one cause after the other. First axis a, second axis b of the plane,
/// radius R, feed v, direction s = +1 counter-clockwise, sgn(a') = -s sgn(sin t), sgn(b') = s sgn(cos t):
///
///   centre            c_a cos t + c_b sin t
///   radius            dR
///   scale mismatch    (s_a - s_b) (R / 2) cos 2t
///   squareness        -beta (R / 2) sin 2t            beta = E_C0Y of the plane XY: the axes open wider
///   servo mismatch    s (tau_a - tau_b) (v / 2) sin 2t
///   backlash          -(B_a / 2) sgn(a') cos t,  -(B_b / 2) sgn(b') sin t      lost motion B > 0: outwards
///   lateral play      (p_a / 2) sgn(a') sin t,   (p_b / 2) sgn(b') cos t
///   straightness      k_a (R^2 / 4)(sin t + sin 3t),  k_b (R^2 / 4)(cos t - cos 3t)   E_ba = k_a a^2
///   cyclic            (C cos(2 pi R cos t / P) + S sin(..)) cos t, and for b with sin t
///   reversal spike    h exp(-time since the reversal / T), after each of the four reversals
///
/// The mean scale cannot be told from the radius; servo mismatch needs both directions.
struct DiagnosisTerm {
  enum class Kind {
    centre,          ///< mm
    radius,          ///< mm
    scale_mismatch,  ///< mm/mm
    squareness,      ///< rad
    servo_mismatch,  ///< s
    backlash,        ///< mm
    lateral_play,    ///< mm
    straightness,    ///< 1/mm
    cyclic_cosine,   ///< mm
    cyclic_sine,     ///< mm
    spike,           ///< mm
  } kind = Kind::centre;
  std::string axis;  ///< "X"; of spikes "X+" (reversal at the positive end); empty: of the plane
  double value = 0;
  double uncertainty = 0;  ///< standard uncertainty; 0 where not separable
  double effect = 0;       ///< largest radial effect over the samples, mm
  bool separable = true;   ///< false: these runs do not tell it from the others
};

struct DiagnosisOptions {
  /// Screw pitches of the first and second axis, mm; nothing: no cyclic error is fitted.
  std::array<std::optional<double>, 2> pitch;
  bool find_pitch = true;  ///< looks for the strongest cyclic error of each axis where no pitch is given
  bool find_spikes = true;
};

/// With fewer samples beyond the unknowns one of many shapes always fits: none is looked for.
inline constexpr int kFewestSpare = 20;

struct Diagnosis {
  bool solved = false;                         ///< false: numbers that are too large
  std::vector<DiagnosisTerm> terms;            ///< in the order above
  std::array<std::optional<double>, 2> pitch;  ///< of the cyclic terms, given or found, mm
  std::array<bool, 2> pitch_found{};           ///< found in the trace, not given
  std::optional<double> spike_time;            ///< T, s; nothing: no spikes that stand out of the noise
  ResidualSummary residuals;                   ///< of what no cause explains
  int spare = 0;  ///< samples beyond the causes; with few the residuals say nothing
  std::vector<std::vector<double>> residual;  ///< per run, mm; 0 at the reversals themselves
  double harmonic_only_servo = 0;  ///< s: what the second harmonic alone would say (backlash leaks in)

  [[nodiscard]] const DiagnosisTerm* find(DiagnosisTerm::Kind kind, std::string_view axis = {}) const;
};

/// One joint least squares over all runs of a test. Uncertainties are from the residuals, times their
/// tau (abbe/core/residuals.h): neighbouring samples are not independent. Samples at a reversal itself are
/// left out: they are on neither side of its step.
///
/// errors   solved = false; terms the runs cannot separate are marked
/// laws     WorkedExampleIsReturnedExactly, BacklashDoesNotLeakIntoServoMismatch, TermHasItsSign
/// cost     some tens of fits of n rows and about 20 columns
/// source   docs/theory/ball-bar.md, section 3
[[nodiscard]] Diagnosis diagnose(const BallbarTest& test, const DiagnosisOptions& options = {});

[[nodiscard]] std::string_view to_string(DiagnosisTerm::Kind kind);

}  // namespace abbe
