#include <fmt/core.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/gear/exact_cut.h"
#include "abbe/gear/gear_cl.h"
#include "abbe/gear/pose_estimate.h"
#include "csv.h"
#include "gear_machine.h"
#include "gear_report.h"
#include "number_check.h"
#include "output_file.h"
#include "progress.h"
#include "text.h"

namespace abbe::app {
namespace {

constexpr double kClTolerance = 0.5 * um;
constexpr double kTold = 0.999;  // determined beyond this: the flanks tell this one by itself

struct GearCorrectArguments {
  GearMachineArguments machine;
  std::string measured, output, motions;
  double sigma_um = 0;
  std::string cut_with = "none";
};

struct CorrectAnswer {
  const GearOnMachine& loaded;
  const GearCorrectArguments& arguments;
  PoseEstimate estimate;
  std::size_t left_out = 0;   ///< points that are not on the flank
  bool by_poses = true;       ///< false: an axis or its travel is missing, the axes do what they can
  GearFigures before, after;  ///< of the machine file: nominal poses, corrected poses
};

/// Columns of the file of measured flanks.
struct MeasuredColumns {
  std::size_t tooth = 0, flank = 0, roll = 0, z = 0, deviation = 0;
  std::optional<std::size_t> trace;
};

std::optional<MeasuredColumns> find_columns(const CsvReader& csv, const std::string& file, Session& session) {
  std::map<std::string, std::size_t> at;
  for (std::size_t i = 0; i < csv.header().size(); ++i) at[csv.header()[i]] = i;
  for (const char* name : {"tooth", "flank", "roll_mm", "z_mm", "deviation_um"}) {
    if (at.contains(name)) continue;
    Diagnostic error;
    error.code = "E-COLUMN";
    error.place.file = file;
    error.message = fmt::format("the column {} is missing", name);
    error.fix = "tooth,flank,roll_mm,z_mm,deviation_um, as `abbe gear cut --points` writes it";
    session.report(error);
    return std::nullopt;
  }
  MeasuredColumns columns{at["tooth"], at["flank"], at["roll_mm"], at["z_mm"], at["deviation_um"], {}};
  if (at.contains("trace")) columns.trace = at["trace"];
  return columns;
}

/// The point of this row; nullopt after telling the reader why not.
std::optional<MeasuredFlankPoint> point_of(CsvReader& csv, const MeasuredColumns& columns, const Gear& gear) {
  const auto tooth = csv.number(columns.tooth), roll = csv.number(columns.roll), z = csv.number(columns.z),
             deviation = csv.number(columns.deviation);
  const auto trace = columns.trace ? csv.number(*columns.trace) : std::optional<double>(-1);
  if (!tooth || !roll || !z || !deviation || !trace) return std::nullopt;
  const auto whole = [](double value, double low, double high) {
    return value >= low && value <= high && value == static_cast<double>(static_cast<int>(value));
  };
  const std::string_view flank = csv.text(columns.flank);
  if (!whole(*tooth, 1, gear.spec.teeth)) {
    csv.fail_at(columns.tooth, "E-CELL", fmt::format("the gear has teeth 1 to {}", gear.spec.teeth));
  } else if (flank != "right" && flank != "left") {
    csv.fail_at(columns.flank, "E-CELL", "a flank is right or left");
  } else if (!whole(*trace, -1, 1e6)) {
    csv.fail_at(*columns.trace, "E-CELL", "a trace is a whole number; -1: no offset");
  } else {
    return MeasuredFlankPoint{static_cast<int>(*tooth), flank == "right" ? Flank::right : Flank::left,
                              *roll / gear.base_radius, *z,
                              *deviation * um,          static_cast<int>(*trace)};
  }
  return std::nullopt;
}

std::optional<std::vector<MeasuredFlankPoint>> read_measured(const std::string& path, const Gear& gear,
                                                             Session& session) {
  FileResult<CsvReader> opened = CsvReader::open(path);
  if (const auto* error = std::get_if<FileError>(&opened)) {
    session.report(*error, path);
    return std::nullopt;
  }
  CsvReader& csv = std::get<CsvReader>(opened);
  std::vector<MeasuredFlankPoint> points;
  if (!csv.failed()) {
    const std::optional<MeasuredColumns> columns = find_columns(csv, path, session);
    if (!columns) return std::nullopt;
    while (csv.next()) {
      const std::optional<MeasuredFlankPoint> point = point_of(csv, *columns, gear);
      if (!point) break;
      points.push_back(*point);
    }
  }
  if (csv.failed()) {
    session.report(*csv.failure(), csv.broken() ? Exit::internal : Exit::invalid);
    return std::nullopt;
  }
  return points;
}

std::string text_of(const CorrectAnswer& answer) {
  const PoseEstimate& estimate = answer.estimate;
  std::string text =
      fmt::format("{} points; rank {} of {}; rms {} um measured, {} um not explained, {} um at most\n",
                  estimate.points, estimate.rank, kPoseUnknowns, um_text(estimate.rms_before),
                  um_text(estimate.rms_after, 3), um_text(estimate.largest_after, 3));
  if (answer.left_out > 0)
    text +=
        fmt::format("{} points left out: not between form and tip, or beyond the face\n", answer.left_out);
  text += "deviations told by the flanks one by one:\n";
  std::string others;
  for (std::size_t i = 0; i < kPoseUnknowns; ++i) {
    const PoseUnknown unknown = pose_unknown(i);
    if (estimate.determined[i] < kTold) {
      others += (others.empty() ? "" : " ") + name_of(unknown);
      continue;
    }
    const bool rotation = unknown.direction >= 3;
    std::string value, u;
    append_fixed(value, estimate.value[i] / (rotation ? urad : um), 2);
    append_fixed(u, estimate.uncertainty[i] / (rotation ? urad : um), 2);
    text += fmt::format("  {:<16}{:>9} +- {:>5} {}\n", name_of(unknown), value, u, rotation ? "urad" : "um");
  }
  if (!others.empty()) text += "told only together, or not at all: " + others + "\n";
  text += "\nthe gear by the machine file, um";
  text += fmt::format("\n{:<13}{:>10}{:>12}\n", "", "nominal", "corrected");
  const auto before = worst_of(answer.before), after = worst_of(answer.after);
  for (std::size_t i = 0; i < before.size(); ++i)
    text += fmt::format("{:<13}{:>10}{:>12}\n", before[i].name, um_text(before[i].value),
                        um_text(after[i].value));
  const std::string& cut_with = answer.arguments.cut_with;
  if (!answer.by_poses && cut_with != "flank")
    text +=
        "an axis, or its travel, is missing for the corrected poses: the axes leave the least they can on "
        "the flanks\n";
  text += cut_with == "none"
              ? "send what is corrected without compensation: machine errors are in what was measured\n"
          : cut_with == "pose"
              ? "send what is corrected with the compensation that the measured gear was cut with\n"
              : "send what is corrected as it is: the correction of the flanks for machine errors is in it\n";
  return text;
}

std::string json_of(const CorrectAnswer& answer) {
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "gear correct", answer.loaded.setting.machine);
  const PoseEstimate& estimate = answer.estimate;
  json.member("points", static_cast<std::uint64_t>(estimate.points))
      .member("left_out", static_cast<std::uint64_t>(answer.left_out))
      .member("rank", estimate.rank);
  json.member("rms_measured_um", estimate.rms_before / um).member("rms_left_um", estimate.rms_after / um);
  json.member("largest_left_um", estimate.largest_after / um)
      .member("cut_with", answer.arguments.cut_with)
      .member("by_poses", answer.by_poses);
  json.key("deviations").begin_array();
  for (std::size_t i = 0; i < kPoseUnknowns; ++i) {
    const PoseUnknown unknown = pose_unknown(i);
    json.begin_object(JsonWriter::Layout::one_line).member("name", name_of(unknown));
    json.member(unknown.direction >= 3 ? "value_rad" : "value_mm", estimate.value[i]);
    json.member("u", estimate.uncertainty[i]).member("determined", estimate.determined[i]).end();
  }
  json.end();
  const auto write_worst = [&](const char* name, const GearFigures& figures) {
    json.key(name).begin_object(JsonWriter::Layout::one_line);
    for (const WorstFigure& worst : worst_of(figures))
      json.member(fmt::format("{}_um", worst.name), worst.value / um);
    json.end();
  };
  write_worst("before", answer.before);
  write_worst("after", answer.after);
  json.end();
  return json.take() + "\n";
}

bool is_usable(const PoseEstimate& estimate, const std::string& file, Session& session) {
  if (estimate.status == PoseEstimate::Status::ok && estimate.rank > 0) return true;
  const bool few = estimate.status == PoseEstimate::Status::few_points;
  Diagnostic error;
  error.code = "E-GEAR-POINTS";
  error.place.file = file;
  error.message = few ? "the points are too few to tell how uncertain they are"
                      : "no point of this file is on a flank of the gear, or they say nothing";
  error.why = "poses are found from deviations along profiles and helices";
  error.fix = few ? "--sigma-um, or whole profiles and helices of several teeth"
                  : "roll_mm is the roll length, z_mm the height above the middle of the face";
  session.report(error);
  return false;
}

/// The machine of the file, or without its errors, with these commands; nullopt: not computed, or stopped.
std::optional<MachineCut> cut_with(const GearOnMachine& loaded, const Machine& machine,
                                   const CutOptions& options) {
  ProgressBar bar("gear correct", true, "M gaps");
  auto cut =
      cut_on_machine(machine, loaded.gear.job, loaded.gear.wheel, loaded.motion, options, bar.callback());
  if (!std::holds_alternative<MachineCut>(cut) || std::get<MachineCut>(cut).stopped) return std::nullopt;
  return std::get<MachineCut>(std::move(cut));
}

std::optional<GearFigures> figures_with(const GearOnMachine& loaded, const GearInspection& inspection,
                                        const CutOptions& options) {
  const auto cut = cut_with(loaded, loaded.setting.machine, options);
  return cut ? std::optional(inspection.figures(cut->deviations)) : std::nullopt;
}

/// Axis commands for the corrected poses; nullopt: an axis is missing, or travels end.
std::optional<std::vector<AxisCommands>> commands_by_poses(const GearOnMachine& loaded,
                                                           const PoseChange& change) {
  auto corrected = plan_cutting(loaded.setting.machine, loaded.gear.job, loaded.gear.wheel,
                                loaded.motion.nodes, loaded.motion.commands.front(), change);
  if (auto* motion = std::get_if<CuttingMotion>(&corrected)) return std::move(motion->commands);
  return std::nullopt;
}

/// Axis commands that leave the least of these deviations on the flanks; with those of the machine file where
/// the measured gear was cut so, and nothing is corrected by errors nobody measured.
std::optional<std::vector<AxisCommands>> commands_by_axes(const GearOnMachine& loaded,
                                                          const WheelDeviations& known, CutOptions options,
                                                          Session& session) {
  Machine machine = loaded.setting.machine;
  const bool with_errors = options.correction == CutCorrection::flank;
  if (!with_errors) machine.errors.clear();
  options.correction = CutCorrection::flank;
  options.known = &known;
  auto cut = cut_with(loaded, machine, options);
  if (!cut || (cut->outside && !with_errors)) return std::nullopt;
  if (cut->outside) {
    report_outside(machine.files.front(), session);
    return std::nullopt;
  }
  return std::move(cut->commands);
}

/// False after reporting why there can be no CL data.
bool poses_can_be_written(const GearCorrectArguments& arguments, bool by_poses, Session& session) {
  if (arguments.output.empty() || by_poses) return true;
  session.report(
      option_error("--output",
                   arguments.cut_with == "flank"
                       ? "what is corrected for the flanks are axis commands, not poses"
                       : "this machine lacks an axis, or the travel, that the corrected poses need",
                   "--motions: the axis commands that leave the least on the flanks"));
  return false;
}

void run_gear_correct(const GearCorrectArguments& arguments, Session& session) {
  const std::optional<GearOnMachine> loaded = load_gear_on_machine(arguments.machine, session);
  if (!loaded) return;
  const GearJob& job = loaded->gear.job;
  const WheelInGap& wheel = loaded->gear.wheel;
  const auto points = read_measured(arguments.measured, job.gear, session);
  if (!points) return;
  const auto inspection = GearInspection::make(job.gear, wheel, job.evaluation);
  if (!inspection) return;
  CorrectAnswer answer{
      *loaded, arguments, estimate_pose(job, wheel, *points, arguments.sigma_um * um), 0, true, {}, {}};
  if (!is_usable(answer.estimate, arguments.measured, session)) return;
  answer.left_out = points->size() - answer.estimate.points;
  const WheelDeviations known =
      deviations_of(job, wheel, answer.estimate.value, loaded->motion.stroke, loaded->motion.nodes);
  report_second_order(second_order(job.gear, wheel, known), arguments.measured, session);
  const PoseChange change = [&](std::size_t gap, double height, const TipAndAxis& nominal) {
    return pose_corrected_for(job, wheel, answer.estimate.value, gap, height, nominal);
  };

  CutOptions options = cut_options(*loaded);
  const auto free = free_axes_or_report(loaded->setting.machine, 0, session);
  if (!free) return;
  options.free = *free;
  options.correction = correction_of(arguments.cut_with);
  const bool for_flanks = options.correction == CutCorrection::flank;
  const std::optional<std::vector<AxisCommands>> by_poses =
      for_flanks ? std::nullopt : commands_by_poses(*loaded, change);
  if (!poses_can_be_written(arguments, by_poses.has_value(), session)) return;
  answer.by_poses = by_poses.has_value();
  const auto sent = by_poses ? by_poses : commands_by_axes(*loaded, known, options, session);
  if (!sent || !within_travels(*loaded, *sent, session)) return;
  const std::optional<GearFigures> before = figures_with(*loaded, *inspection, options);
  options.sent = &*sent;
  if (for_flanks) options.correction = CutCorrection::none;  // it is in what is sent
  const std::optional<GearFigures> after = figures_with(*loaded, *inspection, options);
  if (!before || !after) return;
  answer.before = *before;
  answer.after = *after;
  std::vector<std::string> inputs = loaded->inputs;
  inputs.push_back(arguments.measured);
  if (!write_outputs({{"--output", arguments.output,
                       arguments.output.empty()
                           ? ""
                           : write_gear_cl(job, wheel, loaded->motion.axis_sign, kClTolerance, change)},
                      {"--motions", arguments.motions, motions_csv(*loaded, *sent)}},
                     inputs, session))
    return;
  session.out.write(arguments.machine.common.json ? json_of(answer) : text_of(answer));
}

}  // namespace

Verb gear_correct_verb(Command& gear, Session& session) {
  Command* command = gear.add_subcommand("correct", "from measured flanks to poses that make them right");
  auto arguments = std::make_shared<GearCorrectArguments>();
  add_gear_machine_options(*command, arguments->machine, session);
  command->add_option("--measured", arguments->measured, "CSV: tooth,flank,roll_mm,z_mm,deviation_um[,trace]")
      ->required()
      ->type_name("FILE");
  command->add_option("-o,--output", arguments->output, "the cut with corrected poses, as CL data")
      ->type_name("FILE");
  command->add_option("--motions", arguments->motions, "corrected axis commands of every gap: CSV")
      ->type_name("FILE");
  command
      ->add_option("--sigma-um", arguments->sigma_um,
                   "standard uncertainty of a point, 0: from the residuals (0)")
      ->check(not_negative())
      ->type_name("UM");
  command
      ->add_option("--cut-with", arguments->cut_with,
                   "how the measured gear was cut, and the corrected one will be: none, pose, flank (none)")
      ->check(one_of({"none", "pose", "flank"}))
      ->type_name("WHAT");
  return {command, [arguments, &session] { run_gear_correct(*arguments, session); }};
}

}  // namespace abbe::app
