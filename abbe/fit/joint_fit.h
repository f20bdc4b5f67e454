#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "abbe/fit/fit_job.h"
#include "abbe/fit/observations.h"
#include "abbe/fit/unknowns.h"

namespace abbe {

/// A function as it was found.
struct FoundFunction {
  UnknownFunction unknown;
  Eigen::VectorXd mean, reversal;  ///< parameters of the models
  double u = 0;                    ///< largest standard uncertainty of the mean over its range, um or urad
};

struct FoundValue {
  std::string name;
  double value = 0, u = 0;  ///< internal units (locations in um or urad)
};

/// An unknown that the measurements do not tell from others: it was left at zero. Of a function it may be
/// some parameters only, such as the harmonics of a pitch at all of whose multiples it was measured.
struct NotDetermined {
  std::string name;
  std::vector<std::string> like;            ///< what does the same; empty: nothing shows it
  bool asked = false;                       ///< the job names it, or it is part of a function
  std::size_t missing = 0, parameters = 0;  ///< how many were left at zero, and how many there are

  [[nodiscard]] bool in_part() const { return missing < parameters; }
};

/// How well one file is met.
struct SetResidual {
  std::string name;
  bool angle = false, noise_assumed = false;
  std::size_t rows = 0;
  double rms = 0, max = 0;  ///< mm or rad
  double ratio = 0;         ///< rms of residual / standard uncertainty
};

struct FitResult {
  enum class Status { ok, not_finite } status = Status::ok;
  std::vector<FoundFunction> functions;
  std::vector<FoundValue> locations;
  std::vector<FoundValue> nuisances;  ///< mm or rad, in the order of the observations
  std::vector<NotDetermined> not_determined;
  std::vector<SetResidual> sets;
  std::size_t rows = 0, unknowns = 0, rank = 0;
  /// Of all parameters together, um and urad: of each function mean, then reversal; then the locations.
  Eigen::MatrixXd covariance;
  double variance_ratio = 1;  ///< sum of squared weighted residuals per degree of freedom
};

/// All unknowns at once, by weighted least squares on all observations:
///
///   minimise sum ((value - model) / sigma)^2 + sum ((nuisance - expected) / u)^2
///
/// The columns are the chain's own first-order effects (UnitEffects), so lever arms, the side an error is
/// seen from and the order it acts in need no formulas of their own. What is not determined is named and left
/// at zero (independent_columns). The covariance is that of the weights, enlarged by the variance ratio when
/// the residuals are larger than the weights say, or when nothing was known of the noise.
///
/// laws     FindsWhatWasMeasured, OffsetsOfInstrumentsDoNotCount, NamesWhatIsNotDetermined,
/// IntervalsCoverTheTruth cost     one first-order prediction per pose and error, twice; 2 rows unknowns^2
/// operations
[[nodiscard]] FitResult fit_jointly(const FitJob& job, const Observations& observations,
                                    const Unknowns& unknowns);

}  // namespace abbe
