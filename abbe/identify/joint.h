#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/core/residuals.h"
#include "abbe/identify/model_term.h"
#include "abbe/identify/null_space.h"
#include "abbe/identify/paper.h"

namespace abbe {

struct IdentifyOptions {
  TermChoice terms;
  /// Singular values (columns of length 1) below this part of the largest count as zero: along these
  /// combinations the unknowns stay at their least norm. This is the only regularisation.
  double rank_tolerance = 1e-3;
  /// True: of every unseen combination one member is taken for zero (rotations first, then lags, bar lengths,
  /// higher powers, ..), which leaves the simplest explanation. False: least norm, shares are artefacts.
  bool assume_zero = true;
  std::optional<double> noise;    ///< standard deviation of a deviation, mm; instead of what the files say
  double time_offset = 0;         ///< standard uncertainty of the clock of a run, s; 0: clocks agree
  double reversal_window = 0.02;  ///< samples closer to a reversal are left out, s
};

/// One identified coefficient, in mm or rad per unit of its basis (mm^n, mm/s, mm/s^2).
struct IdentifiedTerm {
  ModelTerm term;
  double value = 0;
  double uncertainty = 0;    ///< standard uncertainty; of an artefact that of its determined part
  bool identifiable = true;  ///< false: only sums with others are known (see unseen), whatever is assumed
  enum class Origin {
    measured,  ///< by these tests; where not identifiable, given what is assumed
    assumed,   ///< taken for zero
    artefact,  ///< a share of a sum, chosen by the least norm
  } origin = Origin::measured;
};

/// One run as the model explains it; rms values in mm.
struct RunBalance {
  std::size_t test = 0, run = 0;
  double measured = 0;  ///< about the set-up's centre and length
  double servo = 0;     ///< what the servo sees: u . (6064 - 607A)
  double statics = 0;   ///< static terms
  double dynamics = 0;  ///< velocity and acceleration terms: the mechanical rest
  double residual = 0;
  DynamicShare share;                            ///< servo and dynamic terms against static ones
  DynamicShare low, high;                        ///< its 95 % interval from the covariance
  double time_offset = 0, time_uncertainty = 0;  ///< s
};

struct Identification {
  enum class Status {
    ok,
    no_axes,       ///< an axis of a test is no linear axis of the machine
    no_sign,       ///< an axis of a test carries the workpiece and does not state errors_seen
    too_few_rows,  ///< fewer samples than unknowns that could be seen
    not_finite,
  } status = Status::ok;
  std::vector<IdentifiedTerm> terms;
  std::vector<std::string> names;  ///< of all unknowns: terms, set-ups, time offsets
  Eigen::VectorXd values;          ///< of all unknowns
  Eigen::MatrixXd covariance;      ///< of all unknowns
  Eigen::MatrixXd null_space;      ///< of all unknowns
  Eigen::VectorXd column_length;
  Eigen::VectorXd singular_values;
  Eigen::Index rank = 0, rows = 0, left_out = 0;  ///< left out: too close to a reversal
  std::vector<UnseenCombination> unseen;
  std::vector<std::string> assumptions;  ///< names of the unknowns taken for zero
  std::vector<RunBalance> runs;

  bool noise_known = false;
  double noise = 0;                 ///< mm: given, or from the residuals
  double chi_square = 0;            ///< per degree of freedom; 1 where the noise was estimated
  double inflation = 1;             ///< of the covariance, because of chi_square and tau
  double largest_standardised = 0;  ///< residual over its own standard deviation
  ResidualSummary residuals;        ///< standardised, all runs
  bool trusted = true;              ///< the residuals look like the stated noise
  std::vector<std::string> doubts;  ///< why not

  [[nodiscard]] bool ok() const { return status == Status::ok; }
};

/// One weighted least squares over all tests: planes, radii, feeds, directions, arcs. What the servo sees
/// itself (recorded 6064 - 607A) is taken off first. With a time offset, the clocks of the runs are unknowns,
/// too, with that standard uncertainty as prior, and the problem is iterated (abbe/identify/nonlinear.h).
///
/// errors   see Status
/// laws     ReturnsWhatWasPutIn, IntervalsCoverTheTruth, RanksOfTheTable, UnmodelledCyclicErrorIsFlagged
/// cost     one pass over the rows, two more for the residuals
/// source   docs/theory/identification.md
[[nodiscard]] Identification identify_jointly(const Machine& machine, const std::vector<BallbarTest>& tests,
                                              const IdentifyOptions& options);

/// The radial trace that an identification expects for another run (centre and bar length as set up: zero).
struct TracePrediction {
  std::vector<double> deviation, uncertainty;  ///< mm; standard uncertainty of the model, without new noise
  bool determined = true;  ///< false: depends on a combination that was not seen (beyond centre and length)
};
[[nodiscard]] TracePrediction predict_trace(const Machine& machine, const Identification& identification,
                                            const BallbarTest& test, std::size_t run);

/// What a plan of tests would tell, before anything is measured: rank, null space and the expected standard
/// uncertainty of every term (value 0), with the noise of each test. Runs need angles only.
[[nodiscard]] Identification identifiability(const Machine& machine, const std::vector<BallbarTest>& plan,
                                             const IdentifyOptions& options);

}  // namespace abbe
