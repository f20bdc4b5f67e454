#include "abbe/ballbar/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "abbe/ballbar/diagnosis_model.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

// A cause that was looked for among many has to stand out: F of its columns against what is left.
constexpr double kStandsOut = 25;
constexpr double kShortestPulse = 1e-3, kLongestPulse = 0.2;  // s
constexpr int kPulseSteps = 16;
constexpr double kWidestPulse = 30 * deg, kNarrowestPulse = 2.0;  // of the angle; of the sample distance
constexpr double kShortestPitch = 0.5;                            // mm
constexpr double kWavesOfLongestPitch = 3;                        // at least so many across the circle

double mean_step(const BallbarTest& test) {
  double travel = 0;
  for (const BallbarRun& run : test.runs) travel += travel_of(run);
  return travel / std::max<double>(1, static_cast<double>(test.samples()));
}

/// (S_0 - S_1) / k over S_1 / (n - m), divided by tau: what k more columns gain.
double gain(const DiagnosisFit& without, const DiagnosisFit& with, int more) {
  if (with.solution.freedom() < kFewestSpare) return 0;
  const double left = with.variance() * std::max(1.0, with.summary.tau);
  const double gained = (without.solution.sum_of_squares - with.solution.sum_of_squares) / more;
  return left > 0 ? gained / left : gained > 0 ? kStandsOut * 2 : 0.0;
}

/// The best time constant of the pulses after reversals, if they stand out.
void find_spikes(DiagnosisModel& model, DiagnosisFit& fit, const BallbarTest& test) {
  const DiagnosisFit plain = fit;
  const double step = mean_step(test), angular_feed = test.feed / test.radius;
  for (int i = 0; i < kPulseSteps; ++i) {
    const double time = kShortestPulse * std::pow(kLongestPulse / kShortestPulse, i / (kPulseSteps - 1.0));
    const double width = angular_feed * time;
    if (width < kNarrowestPulse * step || width > kWidestPulse) continue;
    DiagnosisModel with = model;
    with.set_spikes(time);
    DiagnosisFit candidate = with.fit();
    if (!candidate.ok() || gain(plain, candidate, 4) < kStandsOut) continue;
    if (candidate.solution.sum_of_squares >= fit.solution.sum_of_squares) continue;
    fit = std::move(candidate);
    model = std::move(with);
  }
}

/// Looks for a cyclic error of one axis in what a fit leaves: r ~ (C cos(2 pi f R u) + S sin(..)) u.
class PitchSearch {
 public:
  PitchSearch(const BallbarTest& test, const DiagnosisFit& fit, int axis) : test_(test) {
    for (std::size_t k = 0; k < test.runs.size(); ++k) {
      for (std::size_t i = 0; i < fit.residual[k].size(); ++i) {
        const double angle = test.runs[k].angle[i];
        u_.push_back(axis == 0 ? std::cos(angle) : std::sin(angle));
        residual_.push_back(fit.residual[k][i]);
      }
    }
  }

  /// The pitch with the largest power, refined between the frequencies of a grid fine enough to miss none.
  [[nodiscard]] double strongest() const {
    // The fastest wave that a trace shows has two samples where the axis is fastest.
    const double shortest = std::max(kShortestPitch, 4 * test_.radius * mean_step(test_));
    const double lowest = kWavesOfLongestPitch / (2 * test_.radius), step = 1 / (16 * test_.radius);
    const auto count = static_cast<int>(std::max(0.0, (1 / shortest - lowest) / step)) + 1;
    // From one frequency to the next every phase grows by the same amount: one complex product.
    std::vector<std::complex<double>> wave, turn;
    for (const double u : u_) {
      wave.push_back(std::polar(1.0, phase(lowest, u)));
      turn.push_back(std::polar(1.0, phase(step, u)));
    }
    double best = lowest, most = -1;
    for (int k = 0; k < count; ++k) {
      if (const double p = power(wave); p > most) most = p, best = lowest + k * step;
      for (std::size_t i = 0; i < wave.size(); ++i) wave[i] *= turn[i];
    }
    return 1 / refined(best - step, best + step);
  }

 private:
  [[nodiscard]] double phase(double frequency, double u) const {
    return 2 * std::numbers::pi * frequency * test_.radius * u;
  }

  /// Sum of squares that the two columns take out of the residual.
  [[nodiscard]] double power(const std::vector<std::complex<double>>& wave) const {
    double cc = 0, ss = 0, cs = 0, rc = 0, rs = 0;
    for (std::size_t i = 0; i < wave.size(); ++i) {
      const double c = wave[i].real() * u_[i], s = wave[i].imag() * u_[i], r = residual_[i];
      cc += c * c, ss += s * s, cs += c * s, rc += r * c, rs += r * s;
    }
    const double determinant = cc * ss - cs * cs;
    return determinant > 1e-9 * cc * ss ? (rc * rc * ss - 2 * rc * rs * cs + rs * rs * cc) / determinant
                                        : 0.0;
  }
  [[nodiscard]] double power_at(double frequency) const {
    std::vector<std::complex<double>> wave;
    for (const double u : u_) wave.push_back(std::polar(1.0, phase(frequency, u)));
    return power(wave);
  }

  /// Golden section.
  [[nodiscard]] double refined(double lo, double hi) const {
    constexpr int kSections = 24;
    for (int i = 0; i < kSections; ++i) {
      const double a = hi - (hi - lo) / std::numbers::phi, b = lo + (hi - lo) / std::numbers::phi;
      if (power_at(a) > power_at(b)) {
        hi = b;
      } else {
        lo = a;
      }
    }
    return (lo + hi) / 2;
  }

  const BallbarTest& test_;
  std::vector<double> u_, residual_;
};

void find_cyclic(DiagnosisModel& model, DiagnosisFit& fit, const BallbarTest& test, Diagnosis& out) {
  for (int axis = 0; axis < 2; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (out.pitch[i]) continue;
    const double pitch = PitchSearch(test, fit, axis).strongest();
    DiagnosisModel with = model;
    with.set_cyclic(axis, pitch);
    DiagnosisFit candidate = with.fit();
    if (!candidate.ok() || gain(fit, candidate, 2) < kStandsOut) continue;
    out.pitch[i] = pitch;
    out.pitch_found[i] = true;
    fit = std::move(candidate);
    model = std::move(with);
  }
}

}  // namespace

const DiagnosisTerm* Diagnosis::find(DiagnosisTerm::Kind kind, std::string_view axis) const {
  const auto at = std::find_if(terms.begin(), terms.end(), [&](const DiagnosisTerm& term) {
    return term.kind == kind && term.axis == axis;
  });
  return at == terms.end() ? nullptr : &*at;
}

Diagnosis diagnose(const BallbarTest& test, const DiagnosisOptions& options) {
  Diagnosis out;
  out.pitch = options.pitch;
  DiagnosisModel model(test);
  for (int axis = 0; axis < 2; ++axis)
    if (const auto& pitch = options.pitch[static_cast<std::size_t>(axis)]) model.set_cyclic(axis, *pitch);
  DiagnosisFit fit = model.fit();
  if (!fit.ok()) return out;
  if (options.find_spikes) find_spikes(model, fit, test);
  if (options.find_pitch) find_cyclic(model, fit, test, out);

  out.solved = true;
  out.spike_time = model.spike_time();
  out.terms = model.terms(fit);
  out.residuals = fit.summary;
  out.spare = static_cast<int>(fit.solution.freedom());
  out.residual = std::move(fit.residual);
  out.harmonic_only_servo = model.harmonic_only_servo();
  return out;
}

std::string_view to_string(DiagnosisTerm::Kind kind) {
  using Kind = DiagnosisTerm::Kind;
  switch (kind) {
    case Kind::centre:
      return "centre offset";
    case Kind::radius:
      return "radius";
    case Kind::scale_mismatch:
      return "scale mismatch";
    case Kind::squareness:
      return "squareness";
    case Kind::servo_mismatch:
      return "servo mismatch";
    case Kind::backlash:
      return "backlash";
    case Kind::lateral_play:
      return "lateral play";
    case Kind::straightness:
      return "straightness";
    case Kind::cyclic_cosine:
      return "cyclic, cosine";
    case Kind::cyclic_sine:
      return "cyclic, sine";
    case Kind::spike:
      return "reversal spike";
  }
  return {};
}

}  // namespace abbe
