#include "abbe/chain/predict.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "abbe/chain/correct.h"
#include "abbe/chain/expanded_prediction.h"
#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"
#include "common.h"
#include "expansion_options.h"
#include "point_source.h"
#include "progress.h"
#include "text.h"
#include "verbs.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

constexpr std::size_t kWriteAt = std::size_t{1} << 16;

/// Angle between the actual and the nominal tool axis, whatever their lengths; exact when small.
double tilt(const Prediction& prediction) {
  const Vec3& a = prediction.nominal.tool_axis;
  const Vec3& b = prediction.actual.tool_axis;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

struct Summary {
  std::uint64_t points = 0, passed = 0;
  double max_distance = 0, max_tilt = 0, sum_of_squares = 0;
  std::string where_distance, where_tilt;

  void add(double distance, double angle, bool pass, const std::string& where) {
    ++points;
    if (pass) ++passed;
    sum_of_squares += distance * distance;
    if (points == 1 || distance > max_distance) max_distance = distance, where_distance = where;
    if (points == 1 || angle > max_tilt) max_tilt = angle, where_tilt = where;
  }
  [[nodiscard]] double rms() const {
    return points == 0 ? 0 : std::sqrt(sum_of_squares / static_cast<double>(points));
  }
};

void write_tip(JsonWriter& json, std::string_view name, const TipAndAxis& tip) {
  json.key(name).begin_object();
  json.member("position_mm", tip.position).member("tool_axis", tip.tool_axis).end();
}

void write_json_point(JsonWriter& json, const Setting& setting, const Query& query,
                      const Prediction& prediction, bool pass) {
  json.begin_object(Layout::one_line);
  write_positions(json, "q", setting.machine, query.q);
  write_tip(json, "nominal", prediction.nominal);
  write_tip(json, "actual", prediction.actual);
  write_tip(json, "deviation", prediction.deviation);
  json.key("tool_twist").begin_object();
  json.member("translation_mm", prediction.tool_twist.d)
      .member("rotation_rad", prediction.tool_twist.e)
      .end();
  json.member("extrapolated", prediction.extrapolated);
  json.member("outside_travel", outside_travel(setting.machine, query.q));
  if (setting.limits.given()) json.member("pass", pass);
  json.end();
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
  return text;
}

std::string block_text(const Setting& setting, const Query& query, const Prediction& prediction, bool pass) {
  const Vec3 d_um = prediction.deviation.position / um;
  const double angle = tilt(prediction);
  std::string text = fmt::format("machine         {} ({} model, {} errors)\ncommanded       {}\n\n",
                                 setting.machine.name, to_string(setting.model),
                                 setting.machine.errors.size(), positions_text(setting.machine, query.q));
  text += fmt::format("{:<16}{:>15}{:>15}{:>15}  in workpiece axes\n", "", "x", "y", "z");
  text += vector_row("nominal tip", prediction.nominal.position, 6, "mm", false);
  text += vector_row("actual tip", prediction.actual.position, 6, "mm", false);
  text += vector_row("deviation", d_um, 3, "um", true, fmt::format("|d| {:.3f} um", d_um.norm()));
  text += vector_row("nominal axis", prediction.nominal.tool_axis, 9, "", false);
  text += vector_row("actual axis", prediction.actual.tool_axis, 9, "", false);
  text += vector_row("tilt", prediction.deviation.tool_axis / urad, 3, "urad", true,
                     fmt::format("{:.3f} urad = {:.3f} arcsec", angle / urad, angle / arcsec));
  text +=
      fmt::format("\n{:<16}{:>15}{:>15}{:>15}  in axes of the ideal tool, at the tip\n", "", "x", "y", "z");
  text += vector_row("displacement", prediction.tool_twist.d / um, 3, "um", true);
  text += vector_row("rotation", prediction.tool_twist.e / urad, 3, "urad", true);
  if (!prediction.extrapolated.empty()) {
    text +=
        fmt::format("\nextrapolated    {} (held beyond their last value)\n", joined(prediction.extrapolated));
  }
  const std::vector<std::string> of_one_test = errors_of_one_test(setting.machine);
  if (!of_one_test.empty())
    text += fmt::format("\nof one test     {} (never compensated)\n", joined(of_one_test));
  const std::vector<std::string> outside = outside_travel(setting.machine, query.q);
  if (!outside.empty()) text += fmt::format("\noutside travel  {}\n", joined(outside));
  if (setting.limits.given()) text += fmt::format("\nlimits          {}\n", pass ? "pass" : "FAIL");
  return text;
}

std::string table_heading(const Setting& setting) {
  std::string text = "#";
  for (int i = 0; i < setting.machine.axis_count(); ++i) {
    const Body& axis = setting.machine.axis(i);
    text +=
        fmt::format("{:>13}", fmt::format("{} {}", axis.name, axis.type == AxisType::rotary ? "deg" : "mm"));
  }
  return text + fmt::format("{:>11}{:>11}{:>11}{:>11}{:>12}{:>10}\n", "dx um", "dy um", "dz um", "|d| um",
                            "tilt urad", "arcsec");
}

std::string table_row(const Setting& setting, const Query& query, const Prediction& prediction, bool pass) {
  std::string text = " ";
  for (int i = 0; i < setting.machine.axis_count(); ++i) {
    text += fmt::format("{:>13.5f}",
                        json_position(setting.machine.axis(i), query.q[static_cast<std::size_t>(i)]));
  }
  const Vec3 d_um = prediction.deviation.position / um;
  const double angle = tilt(prediction);
  text += fmt::format("{:>+11.3f}{:>+11.3f}{:>+11.3f}{:>11.3f}{:>12.3f}{:>10.3f}", d_um.x(), d_um.y(),
                      d_um.z(), d_um.norm(), angle / urad, angle / arcsec);
  if (setting.limits.given()) text += pass ? "  pass" : "  FAIL";
  if (!prediction.extrapolated.empty()) text += "  extrapolated: " + joined(prediction.extrapolated);
  const std::vector<std::string> outside = outside_travel(setting.machine, query.q);
  if (!outside.empty()) text += "  outside travel: " + joined(outside);
  return text + '\n';
}

std::string summary_text(const Setting& setting, const Summary& summary) {
  std::string text = fmt::format(
      "\n{} points   |d| max {:.3f} um at {}, rms {:.3f} um   tilt max {:.3f} urad = {:.3f} arcsec at {}\n",
      summary.points, summary.max_distance / um, summary.where_distance, summary.rms() / um,
      summary.max_tilt / urad, summary.max_tilt / arcsec, summary.where_tilt);
  if (setting.limits.given()) {
    text += fmt::format("{}: {} of {} points within the limits\n",
                        summary.passed == summary.points ? "pass" : "FAIL", summary.passed, summary.points);
  }
  return text;
}

void predict_points(const CommonArguments& common, const PointArguments& arguments,
                    const ExpansionArguments& workpiece, Session& session) {
  const std::optional<Setting> setting = load_setting(common, session);
  if (!setting) return;
  const std::optional<WorkpieceExpansion> expansion = expansion_or_report(workpiece, session);
  if (!expansion) return;
  std::optional<PointSource> source = PointSource::open(arguments, *setting, session);
  if (!source) return;

  JsonWriter json;
  if (common.json) {
    json.begin_object();
    write_preamble(json, "predict", setting->machine);
    json.member("model", to_string(setting->model));
    json.member("of_one_test", errors_of_one_test(setting->machine)).key("points").begin_array();
  } else if (!source->single()) {
    session.out.write(table_heading(*setting));
  }

  Summary summary;
  ProgressBar bar("predict", common.json && !source->single());
  while (!interrupted() && session.out.ok() && source->next(session)) {
    const Query query = source->query();
    const Prediction prediction =
        workpiece.given()
            ? expanded(predict(source->plan(), query), nominal_pose(source->plan(), query), *expansion)
            : predict(source->plan(), query);
    if (!prediction.finite) {
      Diagnostic overflow = option_error(source->where(), "the numbers are too large to calculate with");
      overflow.code = "E-RANGE";
      session.report(overflow);
      break;
    }
    const double distance = prediction.deviation.position.norm();
    const double angle = tilt(prediction);
    const bool pass = setting->limits.pass(distance, angle);
    summary.add(distance, angle, pass, source->where());
    if (common.json) {
      write_json_point(json, *setting, query, prediction, pass);
      if (json.pending() > kWriteAt) session.out.write(json.take());
    } else if (source->single()) {
      session.out.write(block_text(*setting, query, prediction, pass));
    } else {
      session.out.write(table_row(*setting, query, prediction, pass));
    }
    bar.show(source->bytes_read(), source->bytes_total());
  }

  const bool complete = !interrupted() && !session.has(Exit::invalid) && !session.has(Exit::internal);
  const bool pass = summary.passed == summary.points;
  if (session.strict && setting->limits.given() && !pass) session.note(Exit::warnings);
  if (common.json) {
    json.end();
    json.key("summary").begin_object(Layout::one_line);
    json.member("points", summary.points).member("max_um", summary.max_distance / um);
    json.member("rms_um", summary.rms() / um).member("max_tilt_rad", summary.max_tilt).end();
    if (setting->limits.given()) json.member("pass", pass && complete);
    json.member("complete", complete).end();
    session.out.write(json.take());
  } else if (!source->single() && complete && summary.points > 0) {
    session.out.write(summary_text(*setting, summary));
  }
}

}  // namespace

Verb predict_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand("predict", "where the tool really is: pose and deviation");
  auto common = std::make_shared<CommonArguments>();
  auto arguments = std::make_shared<PointArguments>();
  add_common_options(*command, *common, session);
  allow_quick_machine(*command, *common);
  auto expansion = std::make_shared<ExpansionArguments>();
  add_point_options(*command, *arguments);
  add_expansion_options(*command, *expansion);
  return {command, [common, arguments, expansion, &session] {
            predict_points(*common, *arguments, *expansion, session);
          }};
}

}  // namespace abbe::app
