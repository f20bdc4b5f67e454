#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/signal/denoise.h"
#include "abbe/signal/resample.h"
#include "abbe/signal/smooth.h"

namespace abbe::app {

/// The steps of `abbe filter`, as --step names them.
struct SmoothStep {
  int passes = 1;
};
struct WaveletStepOptions {
  std::string wavelet = "sym5";
  DenoiseOptions options;
};
struct DerivativeStep {};
struct ResampleStep {
  double spacing = 0;  ///< s
  Interpolation kind = Interpolation::cubic;
};
using FilterStep = std::variant<SmoothStep, SavitzkyGolay, WaveletStepOptions, DerivativeStep, ResampleStep>;

/// "smooth=2", "savitzky-golay=11,3,1", "wavelet=sym5,levels=5,soft,sigma=level,count=coefficients",
/// "derivative", "resample=0.001,linear"; nothing after a diagnostic about --step.
[[nodiscard]] std::optional<FilterStep> read_step(const std::string& text, Diagnostics& diagnostics);

/// A column on its way through the steps.
struct FilteredColumn {
  std::string name;
  Samples samples;
  std::vector<Denoised> denoised;  ///< figures of each wavelet step, samples left out
};

/// Times and columns; `spacing` is 0 while the times are not equally spaced.
struct FilteredRecord {
  Samples times;
  double spacing = 0;
  std::vector<FilteredColumn> columns;
};

/// The record after one step, or why not.
[[nodiscard]] std::optional<Diagnostic> apply_step(const FilterStep& step, const std::string& file,
                                                   FilteredRecord& record);

/// The spacing of equally spaced times (to 1e-6 of it); 0 if they are not.
[[nodiscard]] double equal_spacing(const Samples& times);

/// A finding about a record: E-SIGNAL.
[[nodiscard]] Diagnostic signal_error(const std::string& file, std::string message, std::string fix = {});

}  // namespace abbe::app
