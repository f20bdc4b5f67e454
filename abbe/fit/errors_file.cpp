#include "abbe/fit/errors_file.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <set>

#include "abbe/fit/function_model.h"

namespace abbe {
namespace {

/// A text in TOML's quotes; control bytes would not be TOML.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      out += '?';
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string comment(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return "# " + text + "\n";
}

std::string function_text(const FoundFunction& found) {
  std::string text = found.unknown.mean.text(found.mean);
  if (found.reversal.size() == 0) return text.find("}, {") == std::string::npos ? text : "[" + text + "]";
  // mean + approach * reversal / 2
  const std::string forward = found.unknown.reversal->text(found.reversal / 2);
  const std::string backward = found.unknown.reversal->text(-found.reversal / 2);
  return fmt::format("[{}, {{ forward = {}, backward = {} }}]", text, forward, backward);
}

std::string calibration_text(const Calibration& calibration) {
  std::string text;
  if (!calibration.date.empty()) text += fmt::format("date = {}\n", calibration.date);
  if (!calibration.valid_to.empty()) text += fmt::format("valid_to = {}\n", calibration.valid_to);
  if (!calibration.machine_id.empty())
    text += fmt::format("machine_id = {}\n", quoted(calibration.machine_id));
  if (calibration.temperature)
    text += fmt::format("temperature = {}\n", file_number(*calibration.temperature));
  if (!calibration.control_compensation.empty())
    text += fmt::format("control_compensation = {}\n", quoted(calibration.control_compensation));
  return text.empty() ? text : "\n[calibration]\n" + text;
}

/// slope (T - reference), held outside the temperatures that were seen
std::string term_text(const ThermalTerm& term, double reference) {
  return fmt::format("{{ poly = [0, {}], of = \"{}\", reference = {}, domain = [{}, {}] }}",
                     file_number(term.slope), variable_of(term), file_number(reference), file_number(term.lo),
                     file_number(term.hi));
}

std::string model_text(const ThermalModel& model, double reference) {
  if (model.terms.empty()) return "0";
  std::string text;
  for (const ThermalTerm& term : model.terms) text += (text.empty() ? "" : ", ") + term_text(term, reference);
  return model.terms.size() == 1 ? text : "[" + text + "]";
}

std::string thermal_comments(const FitJob& job, const ThermalFit& thermal) {
  std::string text;
  for (const FitDrift& drift : job.drifts)
    text += comment(fmt::format("  {}: {} rows over {:.0f} min{}", drift.file, drift.times.size(),
                                (drift.times.back() - drift.times.front()) / 60,
                                drift.validation ? ", only to judge" : "") +
                    (drift.settled ? ", taken to begin settled" : ", its state at the start not known"));
  for (const ThermalModel& model : thermal.models)
    text +=
        comment(fmt::format("  {}: drift {:.3g} rms, left {:.3g}{} {}", model.name, model.before, model.left,
                            model.validated ? fmt::format(", of logs not fitted {:.3g}", *model.validated)
                                            : std::string(", not tried on another log"),
                            model.rotation ? "urad" : "um"));
  return text;
}

/// Each lagged temperature once, in the order of its first use.
std::string sensors_text(const ThermalFit& thermal) {
  std::string text;
  std::set<std::string> written;
  for (const ThermalModel& model : thermal.models)
    for (const ThermalTerm& term : model.terms)
      if (term.lag > 0 && written.insert(variable_of(term)).second)
        text +=
            fmt::format("{} = {{ of = \"{}\", lag = {:.0f} }}\n", variable_of(term), term.sensor, term.lag);
  return text.empty()
             ? text
             : "\n[sensors]\n" + comment("first-order lags (s) of temperatures that are read") + text;
}

}  // namespace

std::string write_errors_file(const FitJob& job, const FitResult& result, const ThermalFit& thermal) {
  std::string text =
      comment("Written by abbe fit from " + job.file + ": errors of " + job.machine.name + ".");
  for (const SetResidual& set : result.sets)
    text += comment(fmt::format("  {}: {} equations, rms of what is left {:.3g} {}", set.name, set.rows,
                                set.rms / (set.angle ? urad : um), set.angle ? "urad" : "um"));
  text += thermal_comments(job, thermal);
  text += comment(
      "All functions are zero at the reference position. Straightness has no trend: it is squareness.");
  text +=
      "format = 1\n\n[units]\nlength = \"mm\"\nangle = \"deg\"\nerror_length = \"um\"\nerror_angle = "
      "\"urad\"\n";
  text += calibration_text(job.calibration);
  text += "\n[errors]\n";
  for (const FoundFunction& found : result.functions)
    text += fmt::format("{} = {}\n", found.unknown.name, function_text(found));
  for (const FoundValue& value : result.locations)
    text += fmt::format("{} = {}\n", value.name, file_number(value.value));
  for (const ThermalModel& model : thermal.models)
    text += fmt::format("{} = {}\n", model.name, model_text(model, job.thermal.reference));
  text += sensors_text(thermal);
  text += "\n[uncertainty]\n" +
          comment("standard; of functions the largest over their range, of the mean of both directions");
  for (const FoundFunction& found : result.functions)
    text += fmt::format("{} = {}\n", found.unknown.name, file_number(found.u));
  for (const FoundValue& value : result.locations)
    text += fmt::format("{} = {}\n", value.name, file_number(value.u));
  for (const ThermalModel& model : thermal.models)
    text += fmt::format("{} = {}\n", model.name, file_number(model.u));
  return text;
}

namespace {

/// L of C = L L^T; columns of pivots that are zero (what is not determined) stay zero.
Eigen::MatrixXd cholesky_factor(const Eigen::MatrixXd& C) {
  constexpr double kZero = 1e-12;
  const Eigen::Index n = C.rows();
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const Eigen::VectorXd rest =
        C.col(j).tail(n - j) - L.bottomLeftCorner(n - j, j) * L.row(j).head(j).transpose();
    if (rest[0] > kZero * C(j, j)) L.col(j).tail(n - j) = rest / std::sqrt(rest[0]);
  }
  return L;
}

/// One column of L as a table of errors.
std::string mode_text(const FitResult& result, const Eigen::VectorXd& column) {
  std::string text;
  Eigen::Index first = 0;
  for (const FoundFunction& found : result.functions) {
    FoundFunction share = found;
    share.mean = column.segment(first, found.mean.size());
    share.reversal = column.segment(first + found.mean.size(), found.reversal.size());
    first += found.mean.size() + found.reversal.size();
    if (!share.mean.isZero(0) || !share.reversal.isZero(0))
      text += fmt::format("{} = {}\n", found.unknown.name, function_text(share));
  }
  for (const FoundValue& value : result.locations)
    if (const double share = column[first++]; share != 0)
      text += fmt::format("{} = {}\n", value.name, file_number(share));
  return text;
}

/// One column of L as a table of thermal errors.
std::string thermal_mode_text(const ThermalFit& thermal, const Eigen::VectorXd& column, double reference) {
  std::string text;
  Eigen::Index next = 0;
  for (const ThermalModel& model : thermal.models) {
    ThermalModel share = model;
    share.terms.clear();
    for (ThermalTerm term : model.terms)
      if ((term.slope = column[next++]) != 0) share.terms.push_back(term);
    if (!share.terms.empty()) text += fmt::format("{} = {}\n", model.name, model_text(share, reference));
  }
  return text;
}

/// A table for every column of L that `text_of` says anything of.
template <class TextOf>
std::string modes_of(const Eigen::MatrixXd& C, const TextOf& text_of) {
  constexpr double kNegligible = 1e-4;
  const Eigen::MatrixXd L = cholesky_factor(C);
  std::string text;
  for (Eigen::Index j = 0; j < L.cols(); ++j) {
    Eigen::VectorXd column = L.col(j);
    for (Eigen::Index i = 0; i < column.size(); ++i)
      if (std::abs(column[i]) <= kNegligible * std::sqrt(C(i, i))) column[i] = 0;
    const std::string mode = text_of(column);
    if (!mode.empty()) text += "\n[[uncertainty_mode]]\n" + mode;
  }
  return text;
}

}  // namespace

std::string write_uncertainty_modes(const FitJob& job, const FitResult& result, const ThermalFit& thermal) {
  std::string text =
      "\n" + comment("covariance: each mode is one standard deviation of all its errors together");
  text +=
      modes_of(result.covariance, [&](const Eigen::VectorXd& column) { return mode_text(result, column); });
  if (thermal.models.empty()) return text;
  text += modes_of(thermal.covariance, [&](const Eigen::VectorXd& column) {
    return thermal_mode_text(thermal, column, job.thermal.reference);
  });
  for (const ThermalModel& model : thermal.models)
    text += fmt::format("\n[[uncertainty_mode]]\n{} = {}\n", model.name, file_number(model.beyond_slopes));
  return text;
}

}  // namespace abbe
