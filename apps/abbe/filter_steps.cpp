#include "filter_steps.h"

#include <fmt/core.h>

#include <array>
#include <cmath>

#include "abbe/core/number.h"
#include "abbe/signal/differentiate.h"
#include "common.h"

namespace abbe::app {
namespace {

constexpr double kSameSpacing = 1e-6;

/// The words of a step behind its "=".
struct Words {
  std::string step;
  std::vector<std::string> list;
  Diagnostics& diagnostics;
  bool good = true;

  void complain(const std::string& word, const char* fix) {
    diagnostics.push_back(option_error("--step", fmt::format("{}: '{}' is not understood", step, word), fix));
    good = false;
  }
  std::optional<int> whole(const std::string& text, const char* fix) {
    const auto number = read_number(text);
    if (number && std::floor(*number) == *number && std::abs(*number) < 1e6) return static_cast<int>(*number);
    complain(text, fix);
    return std::nullopt;
  }
};

std::optional<FilterStep> read_smooth(Words& words) {
  constexpr const char* kForm = "smooth, or smooth=PASSES";
  SmoothStep step;
  if (words.list.size() > 1) words.complain(words.list[1], kForm);
  if (!words.list.empty()) step.passes = words.whole(words.list[0], kForm).value_or(1);
  return step;
}

std::optional<FilterStep> read_savitzky_golay(Words& words) {
  constexpr const char* kForm = "savitzky-golay=WINDOW,ORDER or savitzky-golay=WINDOW,ORDER,DERIVATIVE";
  SavitzkyGolay step;
  const std::array<int*, 3> places = {&step.window, &step.order, &step.derivative};
  if (words.list.size() < 2 || words.list.size() > 3)
    words.complain(fmt::format("{} numbers", words.list.size()), kForm);
  for (std::size_t i = 0; i < words.list.size() && i < 3; ++i)
    *places[i] = words.whole(words.list[i], kForm).value_or(0);
  return step;
}

std::optional<FilterStep> read_wavelet(Words& words) {
  constexpr const char* kForm =
      "wavelet=NAME[,levels=5][,hard|soft][,sigma=first|level|one][,count=samples|coefficients], NAME db1 to "
      "db20, "
      "sym2 to sym20";
  WaveletStepOptions step;
  for (std::size_t i = 0; i < words.list.size(); ++i) {
    const std::string& word = words.list[i];
    if (i == 0 && find_wavelet(word))
      step.wavelet = word;
    else if (word == "hard")
      step.options.threshold = DenoiseOptions::Threshold::hard;
    else if (word == "soft")
      step.options.threshold = DenoiseOptions::Threshold::soft;
    else if (word == "sigma=first")
      step.options.sigma = DenoiseOptions::Sigma::first;
    else if (word == "sigma=level")
      step.options.sigma = DenoiseOptions::Sigma::per_level;
    else if (word == "sigma=one")
      step.options.sigma = DenoiseOptions::Sigma::one;
    else if (word == "count=samples")
      step.options.count = DenoiseOptions::Count::samples;
    else if (word == "count=coefficients")
      step.options.count = DenoiseOptions::Count::coefficients;
    else if (word.starts_with("levels="))
      step.options.levels = words.whole(word.substr(7), kForm).value_or(1);
    else
      words.complain(word, kForm);
  }
  return step;
}

std::optional<FilterStep> read_resample(Words& words) {
  constexpr const char* kForm = "resample=SECONDS, or resample=SECONDS,linear";
  ResampleStep step;
  const auto spacing = words.list.empty() ? std::nullopt : read_number(words.list[0]);
  if (!spacing || !(*spacing > 0)) words.complain(words.list.empty() ? "" : words.list[0], kForm);
  step.spacing = spacing.value_or(1);
  for (std::size_t i = 1; i < words.list.size(); ++i) {
    if (words.list[i] == "linear")
      step.kind = Interpolation::linear;
    else if (words.list[i] != "cubic")
      words.complain(words.list[i], kForm);
  }
  return step;
}

/// x_mm -> x_mm_per_s -> x_mm_per_s2 ..
std::string derivative_name(const std::string& name) {
  const std::size_t at = name.rfind("_per_s");
  if (at == std::string::npos) return name + "_per_s";
  const std::string power = name.substr(at + 6);
  if (power.empty()) return name + "2";
  const auto number = read_number(power);
  return number ? fmt::format("{}_per_s{}", name.substr(0, at), static_cast<int>(*number) + 1)
                : name + "_per_s";
}

/// Applies `work` to every column.
template <class Work>
std::optional<Diagnostic> each_column(const std::string& file, FilteredRecord& record, const Work& work) {
  for (FilteredColumn& column : record.columns) {
    SignalResult<Samples> result = work(column);
    if (const auto* problem = std::get_if<SignalProblem>(&result))
      return signal_error(file, fmt::format("{}: {}", column.name, abbe::to_string(*problem)));
    column.samples = std::move(std::get<Samples>(result));
  }
  return std::nullopt;
}

std::optional<Diagnostic> resample_all(const ResampleStep& step, const std::string& file,
                                       FilteredRecord& record) {
  auto misfit = each_column(file, record, [&](FilteredColumn& column) -> SignalResult<Samples> {
    auto made = resample(record.times, column.samples, step.spacing, step.kind);
    if (const auto* problem = std::get_if<SignalProblem>(&made)) return *problem;
    return std::move(std::get<UniformRecord>(made).samples);
  });
  if (misfit) return misfit;
  const double first = record.times.front();
  record.spacing = step.spacing;
  record.times.resize(record.columns.front().samples.size());
  for (std::size_t i = 0; i < record.times.size(); ++i)
    record.times[i] = first + static_cast<double>(i) * step.spacing;
  return std::nullopt;
}

SignalResult<Samples> apply_to(const FilterStep& step, double spacing, FilteredColumn& column) {
  if (const auto* smooth = std::get_if<SmoothStep>(&step))
    return five_point_smooth(column.samples, smooth->passes);
  if (const auto* fit = std::get_if<SavitzkyGolay>(&step)) {
    SavitzkyGolay options = *fit;
    options.spacing = spacing;
    for (int k = 0; k < options.derivative; ++k) column.name = derivative_name(column.name);
    return savitzky_golay(column.samples, options);
  }
  if (const auto* wavelet = std::get_if<WaveletStepOptions>(&step)) {
    SignalResult<Denoised> result =
        denoise(column.samples, *find_wavelet(wavelet->wavelet), wavelet->options);
    if (const auto* problem = std::get_if<SignalProblem>(&result)) return *problem;
    auto& denoised = std::get<Denoised>(result);
    Samples samples = std::move(denoised.samples);
    denoised.samples.clear();
    column.denoised.push_back(std::move(denoised));
    return samples;
  }
  column.name = derivative_name(column.name);
  return differentiate(column.samples, spacing);
}

}  // namespace

Diagnostic signal_error(const std::string& file, std::string message, std::string fix) {
  Diagnostic d;
  d.code = "E-SIGNAL";
  d.place.file = file;
  d.message = std::move(message);
  d.fix = std::move(fix);
  return d;
}

std::optional<FilterStep> read_step(const std::string& text, Diagnostics& diagnostics) {
  const std::size_t equals = text.find('=');
  Words words{text.substr(0, equals), {}, diagnostics};
  if (equals != std::string::npos) words.list = split_list(std::string_view(text).substr(equals + 1));
  std::optional<FilterStep> step;
  if (words.step == "smooth")
    step = read_smooth(words);
  else if (words.step == "savitzky-golay")
    step = read_savitzky_golay(words);
  else if (words.step == "wavelet")
    step = read_wavelet(words);
  else if (words.step == "derivative" && words.list.empty())
    step = DerivativeStep{};
  else if (words.step == "resample")
    step = read_resample(words);
  else
    words.complain(text, "smooth, savitzky-golay, wavelet, derivative, resample");
  return words.good ? step : std::nullopt;
}

double equal_spacing(const Samples& times) {
  if (times.size() < 2) return 0;
  const double spacing = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (!(std::abs(times[i] - times[i - 1] - spacing) <= kSameSpacing * spacing)) return 0;
  }
  return spacing;
}

std::optional<Diagnostic> apply_step(const FilterStep& step, const std::string& file,
                                     FilteredRecord& record) {
  if (const auto* grid = std::get_if<ResampleStep>(&step)) return resample_all(*grid, file, record);
  if (record.spacing == 0)
    return signal_error(file, "the times are not equally spaced",
                        "begin with --step resample=SECONDS; see gaps with abbe capture");
  return each_column(file, record,
                     [&](FilteredColumn& column) { return apply_to(step, record.spacing, column); });
}

}  // namespace abbe::app
