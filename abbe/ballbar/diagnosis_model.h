#pragma once

#include <array>
#include <optional>
#include <vector>

#include "abbe/ballbar/diagnosis.h"
#include "abbe/core/least_squares.h"

namespace abbe {

/// A fit of all samples of a test.
struct DiagnosisFit {
  LeastSquaresSolution solution;
  std::vector<std::vector<double>> residual;  ///< per run, mm
  ResidualSummary summary;

  [[nodiscard]] bool ok() const { return solution.ok(); }
  [[nodiscard]] double variance() const { return solution.variance(); }
};

/// The columns of the joint least squares of diagnosis.h for one test.
class DiagnosisModel {
 public:
  explicit DiagnosisModel(const BallbarTest& test);
  void set_cyclic(int axis, double pitch);  ///< axis 0 or 1 of the plane
  void set_spikes(double time);             ///< pulses exp(-t / time) after the reversals
  [[nodiscard]] std::optional<double> spike_time() const { return spike_time_; }

  [[nodiscard]] DiagnosisFit fit() const;
  [[nodiscard]] std::vector<DiagnosisTerm> terms(const DiagnosisFit& fit) const;
  /// tau_a - tau_b from the direction-odd second harmonic without any other cause, s.
  [[nodiscard]] double harmonic_only_servo() const;

 private:
  struct Column {
    DiagnosisTerm::Kind kind;
    int axis = -1;     ///< of the plane; -1 none
    int end = 0;       ///< of spikes: +1, -1
    double pitch = 0;  ///< of cyclic errors
  };
  /// One sample as the columns see it.
  struct Sample {
    std::array<double, 2> u{};   ///< cos, sin of the angle
    std::array<int, 2> sense{};  ///< sgn of the velocity of each axis
    double angle = 0;
    int direction = +1;
  };
  [[nodiscard]] static Sample sample_of(const BallbarRun& run, std::size_t i);
  [[nodiscard]] double value_of(const Column& column, const Sample& sample) const;
  [[nodiscard]] std::string axis_name(const Column& column) const;

  const BallbarTest* test_;
  std::vector<Column> columns_;
  std::optional<double> spike_time_;
};

}  // namespace abbe
