#include "map_uncertainty.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "output_file.h"
#include "progress.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

/// Largest and root mean square over the points, along x y z.
struct Summary {
  Vec3 max = Vec3::Zero(), rms = Vec3::Zero();
};

Summary summary_of(const std::vector<Vec3>& u) {
  Summary out;
  for (const Vec3& value : u) {
    out.max = out.max.cwiseMax(value);
    out.rms += value.cwiseAbs2() / static_cast<double>(u.size());
  }
  out.rms = out.rms.cwiseSqrt();
  return out;
}

std::string line(const char* what, const std::vector<Vec3>& u) {
  const Summary s = summary_of(u);
  const Vec3 max = s.max / um, rms = s.rms / um, wide = kCoverage95 * max;
  return fmt::format(
      "  {:<28} largest {:8.3f} {:8.3f} {:8.3f}   rms {:8.3f} {:8.3f} {:8.3f}   95 % +- {:.3f} {:.3f} {:.3f} "
      "um\n",
      what, max[0], max[1], max[2], rms[0], rms[1], rms[2], wide[0], wide[1], wide[2]);
}

std::string figure_line(const char* what, const DrawnFigure& figure) {
  return fmt::format("  {:<28} {:8.3f}   u {:.3f}   95 % of the trials {:.3f} to {:.3f} um\n", what,
                     figure.value / um, figure.u / um, figure.low / um, figure.high / um);
}

void write_points(JsonWriter& json, const char* name, const std::vector<Vec3>& u) {
  const Summary s = summary_of(u);
  json.key(name).begin_object(Layout::one_line).member("max_u_um", Vec3(s.max / um));
  json.member("rms_u_um", Vec3(s.rms / um))
      .member("max_expanded_95_um", Vec3(kCoverage95 * s.max / um))
      .end();
}

void write_figure(JsonWriter& json, const char* name, const DrawnFigure& figure) {
  json.key(name).begin_object(Layout::one_line).member("value_um", figure.value / um);
  json.member("mean_um", figure.mean / um).member("u_um", figure.u / um);
  json.member("low_95_um", figure.low / um).member("high_95_um", figure.high / um).end();
}

}  // namespace

void add_uncertainty_options(Command& verb, MapUncertaintyArguments& arguments) {
  verb.add_flag("--uncertainty", arguments.wanted,
                "how uncertain the deviations are, by [uncertainty] of the errors");
  verb.add_option("--trials", arguments.trials, "of Monte Carlo; 0: first order only (1000)")
      ->check(whole_in(0, 1'000'000))
      ->type_name("N");
  verb.add_option("--seed", arguments.seed, "of the random numbers (1)")->type_name("N");
}

std::optional<VolumeUncertainty> uncertainty_or_report(const MapUncertaintyArguments& arguments,
                                                       const Setting& setting, const VolumeQuestion& question,
                                                       const std::string& errors_file, Session& session) {
  const auto fail = [&](const char* option, std::string message, std::string fix) {
    session.report(option_error(option, std::move(message), std::move(fix)));
    return std::nullopt;
  };
  if (setting.machine.files.empty())
    return fail("--uncertainty", "no machine file states an uncertainty", "write a machine file");
  const std::string& path = errors_file.empty() ? setting.machine.files.front() : errors_file;
  if (path == "-" || path == "<stdin>")
    return fail("--uncertainty", "the errors are read once more, and standard input is used up",
                "write them to a file");
  const auto text = read_input(path, session);
  if (!text) return std::nullopt;
  const auto modes = read_uncertainty_modes(setting.machine, {path, *text}, fetch_file);
  session.report(modes.diagnostics);
  if (!modes.value) return std::nullopt;
  if (modes.value->modes.empty())
    return fail("--uncertainty", path + " states no uncertainty",
                "add [uncertainty], or let `abbe fit` write it");
  UncertaintyQuestion asked{question, setting.environment, arguments.trials, arguments.seed};
  if (arguments.trials == 1)
    return fail("--trials", "one trial has no spread", "1000; 0 for first order only");
  if (arguments.trials * question.grid.size() > kMostDraws)
    return fail("--trials",
                fmt::format("{} trials at {} points are too many", arguments.trials, question.grid.size()),
                "fewer trials, or --count 7");
  ProgressBar bar("uncertainty", true, "M poses");
  VolumeUncertainty out = volume_uncertainty(setting.machine, *modes.value, asked, bar.callback());
  if (out.status == VolumeUncertainty::Status::stopped) return std::nullopt;
  if (out.status != VolumeUncertainty::Status::done)
    return fail("--uncertainty",
                "an uncertainty needs a sensor that is not given, or the numbers are too large",
                "--set its value; check [uncertainty]");
  return out;
}

std::string uncertainty_text(const VolumeUncertainty& uncertainty) {
  std::string text = "\nstandard uncertainty of the deviation along x y z\n";
  text += line("first order", uncertainty.u) + line("against the datum", uncertainty.u_from_datum);
  if (uncertainty.u_drawn.empty()) return text;
  text += line("Monte Carlo", uncertainty.u_drawn);
  return text + figure_line("largest distance", uncertainty.max) +
         figure_line("rms distance", uncertainty.rms);
}

void write_uncertainty(JsonWriter& json, const VolumeUncertainty& uncertainty) {
  json.key("uncertainty").begin_object().member("coverage_factor", kCoverage95);
  write_points(json, "first_order", uncertainty.u);
  write_points(json, "from_datum", uncertainty.u_from_datum);
  if (!uncertainty.u_drawn.empty()) {
    write_points(json, "monte_carlo", uncertainty.u_drawn);
    write_figure(json, "max_distance", uncertainty.max);
    write_figure(json, "rms_distance", uncertainty.rms);
  }
  json.end();
}

}  // namespace abbe::app
