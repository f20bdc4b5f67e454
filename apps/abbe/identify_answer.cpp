#include "identify_answer.h"

#include <fmt/core.h>

#include <array>
#include <cmath>

#include "abbe/core/units.h"
#include "abbe/identify/deviation_uncertainty.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

std::string_view origin_of(const IdentifiedTerm& term) {
  switch (term.origin) {
    case IdentifiedTerm::Origin::measured:
      return term.identifiable ? "measured" : "measured, given the assumptions";
    case IdentifiedTerm::Origin::assumed:
      return "assumed zero";
    case IdentifiedTerm::Origin::artefact:
      return "artefact";
  }
  return {};
}

std::string_view origin_of(PaperCoefficient::Origin origin) {
  switch (origin) {
    case PaperCoefficient::Origin::measured:
      return "measured";
    case PaperCoefficient::Origin::artefact:
      return "artefact";
    case PaperCoefficient::Origin::assumed:
      return "assumed";
    case PaperCoefficient::Origin::missing:
      return "missing";
  }
  return {};
}

std::string file_of(const std::vector<BallbarTest>& tests, std::size_t test) { return tests[test].file; }

void write_share(JsonWriter& json, std::string_view name, const DynamicShare& share) {
  json.key(name).begin_object(Layout::one_line);
  json.member("L1", share.l1).member("rms", share.rms).member("energy", share.energy).end();
}

std::string positions_text(const Machine& machine, const DeviationUncertainty& u) {
  std::string text;
  for (std::size_t k = 0; k < u.at.size(); ++k)
    if (u.most[k] > u.least[k])
      text += fmt::format("{}{} {:g}", text.empty() ? "" : ", ", machine.axis(static_cast<int>(k)).name,
                          std::round(u.at[k]));
  return text;
}

std::string space_text(const Machine& machine, const Identification& found,
                       const std::vector<BallbarTest>& tests) {
  const DeviationUncertainty u = uncertainty_of_deviation(machine, found, tests);
  return fmt::format(
      "\nstandard uncertainty of the static deviation in the box of tested positions, without what is taken "
      "for "
      "zero:\n"
      "  rms {:.3g} um; worst {:.3g} um at {} mm (x {:.3g}, y {:.3g}, z {:.3g})\n",
      u.rms / um, u.worst / um, positions_text(machine, u), u.u.x() / um, u.u.y() / um, u.u.z() / um);
}

void write_space(JsonWriter& json, const Machine& machine, const Identification& found,
                 const std::vector<BallbarTest>& tests) {
  const DeviationUncertainty u = uncertainty_of_deviation(machine, found, tests);
  json.key("deviation_uncertainty").begin_object();
  json.member("rms_um", u.rms / um).member("worst_um", u.worst / um);
  json.member("u_um", std::array{u.u.x() / um, u.u.y() / um, u.u.z() / um});
  json.key("at_mm").begin_object(Layout::one_line);
  for (std::size_t k = 0; k < u.at.size(); ++k)
    if (u.most[k] > u.least[k]) json.member(machine.axis(static_cast<int>(k)).name, u.at[k]);
  json.end().end();
}

}  // namespace

ShownTerm shown(const IdentifiedTerm& term) {
  const bool rotation = term.term.name.is_rotation();
  std::string unit = rotation ? "urad" : "um";
  if (term.term.form == ModelTerm::Form::power)
    unit += term.term.power == 1 ? "/mm" : fmt::format("/mm^{}", term.term.power);
  if (term.term.form == ModelTerm::Form::velocity) unit += "/(mm/s)";
  if (term.term.form == ModelTerm::Form::acceleration) unit += "/(mm/s^2)";
  const double scale = rotation ? urad : um;
  return {fmt::format("{:.6g}", term.value / scale + 0.0), fmt::format("{:.3g}", term.uncertainty / scale),
          unit};
}

std::string identification_text(const Machine& machine, const Identification& found,
                                const std::vector<BallbarTest>& tests, bool plan) {
  std::string text =
      fmt::format("{} samples ({} near reversals left out), {} unknowns, rank {}, noise {:.3g} um\n\n",
                  found.rows, found.left_out, found.names.size(), found.rank, found.noise / um);
  text += fmt::format("{:<18}{:>14}{:>12}\n", "term", plan ? "" : "value", plan ? "expected u" : "u");
  for (const IdentifiedTerm& term : found.terms) {
    const ShownTerm s = shown(term);
    const bool zero = term.origin == IdentifiedTerm::Origin::assumed;
    text += fmt::format("{:<18}{:>14}{:>12} {:<12} {}\n", to_string(term.term, machine), plan ? "" : s.value,
                        zero ? "" : s.uncertainty, s.unit, origin_of(term));
  }
  if (!found.unseen.empty()) text += "\nnot seen by these circles:\n";
  for (const UnseenCombination& c : found.unseen) text += fmt::format("  {}\n", c.words);
  if (!found.assumptions.empty()) text += "taken for zero:\n";
  for (const std::string& zero : found.assumptions) text += fmt::format("  {}\n", zero);
  text += space_text(machine, found, tests);
  if (plan) return text;
  text += fmt::format(
      "\nresiduals: chi^2 per degree of freedom {:.3f}, largest {:.1f} standard deviations, lag one "
      "{:+.2f}, tau {:.1f}; covariance times {:.2f}\n",
      found.chi_square, found.largest_standardised, found.residuals.lag_one, found.residuals.tau,
      found.inflation);
  text += found.trusted ? "they look like the noise\n" : "DOUBTFUL:\n";
  for (const std::string& doubt : found.doubts) text += fmt::format("  {}\n", doubt);
  return text;
}

std::string balance_text(const Identification& found, const std::vector<BallbarTest>& tests) {
  std::string text =
      "\nrms per run, um                     feed mm/s  measured     servo    static   dynamic  residual   "
      "dynamic share "
      "(L1), 95 %\n";
  for (const RunBalance& run : found.runs) {
    const BallbarTest& test = tests[run.test];
    text += fmt::format(
        "  {:<28}{:<4}{:>11.1f}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}{:>9.2f} % ({:.2f} .. {:.2f})\n",
        file_of(tests, run.test), test.runs[run.run].direction > 0 ? "CCW" : "CW", test.feed,
        run.measured / um, run.servo / um, run.statics / um, run.dynamics / um, run.residual / um,
        100 * run.share.l1, 100 * run.low.l1, 100 * run.high.l1);
    if (run.time_uncertainty > 0)
      text +=
          fmt::format("    clock {:+.2f} +- {:.2f} ms\n", run.time_offset * 1e3, run.time_uncertainty * 1e3);
  }
  return text;
}

void write_identification(JsonWriter& json, const Machine& machine, const Identification& found,
                          const std::vector<BallbarTest>& tests, bool plan) {
  json.member("rows", static_cast<std::uint64_t>(found.rows)).member("rank", static_cast<int>(found.rank));
  json.member("unknowns", found.names)
      .member("noise_mm", found.noise)
      .member("noise_known", found.noise_known);
  json.key("terms").begin_array();
  for (const IdentifiedTerm& term : found.terms) {
    json.begin_object(Layout::one_line);
    json.member("term", to_string(term.term, machine)).member("error", to_string(term.term.name));
    if (!plan) json.member("value", term.value);
    json.member("uncertainty", term.uncertainty).member("identifiable", term.identifiable);
    json.member("origin", origin_of(term)).end();
  }
  json.end();
  json.key("singular_values")
      .value(std::span<const double>(found.singular_values.data(),
                                     static_cast<std::size_t>(found.singular_values.size())));
  json.key("unseen").begin_array();
  for (const UnseenCombination& c : found.unseen) json.value(c.words);
  json.end();
  json.member("assumed_zero", found.assumptions);
  write_space(json, machine, found, tests);
  if (plan) return;
  json.key("covariance").begin_array();
  for (Eigen::Index i = 0; i < found.covariance.rows(); ++i) {
    const Eigen::VectorXd row = found.covariance.row(i);
    json.value(std::span<const double>(row.data(), static_cast<std::size_t>(row.size())));
  }
  json.end();
  json.key("residuals").begin_object(Layout::one_line);
  json.member("chi_square", found.chi_square).member("inflation", found.inflation);
  json.member("largest_standardised", found.largest_standardised).member("lag_one", found.residuals.lag_one);
  json.member("tau", found.residuals.tau).end();
  json.member("trusted", found.trusted).member("doubts", found.doubts);
  json.key("runs").begin_array();
  for (const RunBalance& run : found.runs) {
    json.begin_object(Layout::one_line);
    json.member("file", file_of(tests, run.test)).member("run", static_cast<std::uint64_t>(run.run + 1));
    json.member("measured_um", run.measured / um).member("servo_um", run.servo / um);
    json.member("static_um", run.statics / um).member("dynamic_um", run.dynamics / um);
    json.member("residual_um", run.residual / um);
    write_share(json, "share", run.share);
    write_share(json, "share_low", run.low);
    write_share(json, "share_high", run.high);
    json.member("clock_s", run.time_offset).member("clock_uncertainty_s", run.time_uncertainty).end();
  }
  json.end();
}

std::string paper_text(const PaperResult& result) {
  std::string text = "equation    unknowns  rank  rms residual, um\n";
  for (const PaperStep& step : result.steps)
    text += fmt::format("  {:<12}{:>4}{:>8}{:>12.4f}\n", step.equation, step.unknowns, step.rank,
                        step.rms_residual / um);
  text += "\ncoefficients (mm, rad, mm displacement)\n";
  for (const PaperCoefficient& c : result.coefficients)
    if (c.origin != PaperCoefficient::Origin::missing)
      text += fmt::format("  {}{:>16.6g}  {}\n", c.name(), c.value, origin_of(c.origin));
  for (std::size_t i = 0; i < result.shares.size(); ++i)
    text += fmt::format("dynamic share of test {}: L1 {:.2f} %, rms {:.2f} %, energy {:.2f} %\n", i + 1,
                        100 * result.shares[i].l1, 100 * result.shares[i].rms, 100 * result.shares[i].energy);
  return text;
}

void write_paper(JsonWriter& json, const PaperResult& result) {
  json.key("steps").begin_array();
  for (const PaperStep& step : result.steps) {
    json.begin_object(Layout::one_line);
    json.member("equation", step.equation).member("unknowns", static_cast<int>(step.unknowns));
    json.member("rank", static_cast<int>(step.rank)).member("rms_residual_mm", step.rms_residual).end();
  }
  json.end();
  json.key("coefficients").begin_object();
  for (const PaperCoefficient& c : result.coefficients) {
    if (c.origin == PaperCoefficient::Origin::missing) continue;
    json.key(c.name()).begin_object(Layout::one_line);
    json.member("value", c.value).member("origin", origin_of(c.origin)).end();
  }
  json.end();
  json.key("dynamic_share").begin_array();
  for (const DynamicShare& share : result.shares) {
    json.begin_object(Layout::one_line);
    json.member("L1", share.l1).member("rms", share.rms).member("energy", share.energy).end();
  }
  json.end();
}

}  // namespace abbe::app
