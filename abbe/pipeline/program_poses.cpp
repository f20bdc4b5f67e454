#include "abbe/pipeline/program_poses.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "abbe/verify/reader.h"
#include "abbe/verify/tip_model.h"

namespace abbe {
namespace {

using verifying::Approach;
using verifying::Frames;
using verifying::kAllAxes;
using verifying::Motion;
using verifying::MotionKind;
using verifying::ProgramReader;
using verifying::TipModel;

constexpr int kDeepest = 12;               // halvings of a piece of a motion
constexpr double kPiece = 5;               // mm: first pieces of a motion
constexpr double kArcPiece = 5 * deg;      // of an arc
constexpr double kTurnPiece = 0.25 * deg;  // and where rotary axes turn: keeps the sweep's bound small
constexpr double kRightAngle = 1e-6;

struct Follower {
  const PoseJob& job;
  const std::function<void(const MotionPoses&)>& found;
  TipModel model;
  ProgramReader reader;
  PoseReport& report;

  std::optional<Affine> to_part = std::nullopt;  ///< workpiece axes -> part, known from the first motion on
  std::optional<int> tool = std::nullopt;
  Vec3 origin = Vec3::Zero();  ///< for which datum and tool hold
  bool placed = false;
  bool connected = false;
  bool has_cut = false;
  double next_plan = 0;
  MotionPoses motion{};

  bool fail(const char* code, std::string message, const char* why, const char* fix);
  bool place(const Motion& next);
  bool use_clock();
  bool follow(const Motion& next);
  bool follow_cycle(const Motion& next);
  [[nodiscard]] ToolPose pose_at(const Motion& next, double s);
  void refine(const Motion& next, double s0, const ToolPose& a, double s1, const ToolPose& b, int depth);
  void put(double s, const ToolPose& pose);
  [[nodiscard]] double seconds_of(const Motion& next) const;
  bool run(const Progress& progress);
};

bool Follower::fail(const char* code, std::string message, const char* why, const char* fix) {
  report.diagnostics.push_back(
      {Severity::error,
       code,
       {reader.name(), static_cast<std::size_t>(reader.line()), 1, 1, reader.source_line()},
       std::move(message),
       why,
       fix});
  return false;
}

/// Tool and datum, whenever the work offset or the tool is another one; the place of the part at the first
/// feed, when the control reckons with the tool that cuts.
bool Follower::place(const Motion& next) {
  const Frames& frames = reader.frames();
  const Vec3 here = frames.system().origin + frames.tool_offset;
  const bool same = placed && here == origin && reader.tool() == tool;
  if (same && (to_part || !next.feeds())) return true;
  if (has_cut && reader.tool() != tool)
    return fail("E-PART-TOOL", "a second tool moves", "the part is cut with one cutter here",
                "inspect the operations one by one");
  if (auto fault = model.use_tool(reader.tool())) {
    fault->place = {reader.name(), static_cast<std::size_t>(reader.line()), 1, 1, reader.source_line()};
    report.diagnostics.push_back(std::move(*fault));
    return false;
  }
  model.stand({{}, {}, false, 0});
  if (job.datum == DatumRule::probed && frames.system().defined == kAllAxes)
    report.datum = model.actual(here, Approach{}, nullptr) - model.nominal(here);
  origin = here;
  tool = reader.tool();
  placed = true;
  if (to_part || !next.feeds()) return true;
  // Program point p: u = p + g92, m = Rz u + origin + offset, tip = A m + b
  const auto tip_of = [&](const Vec3& p) {
    return model.nominal(machine_of(frames, {p + frames.g92, kAllAxes}).at);
  };
  const Vec3 zero = tip_of(Vec3::Zero());
  Affine part{Mat3::Identity(), zero};
  for (Eigen::Index k = 0; k < 3; ++k) part.A.col(k) = tip_of(Vec3::Unit(k)) - zero;
  if ((part.A.transpose() * part.A - Mat3::Identity()).cwiseAbs().maxCoeff() > kRightAngle)
    return fail("E-PART-AXES", "the axes of the program are not at right angles to each other",
                "a surface in its coordinates would be distorted", "check `direction` of the axes");
  to_part = inverse(part);
  return true;
}

/// Takes the plan of the present time. False after reporting.
bool Follower::use_clock() {
  if (!job.plan_at || report.seconds < next_plan) return true;
  next_plan = report.seconds + job.time_step;
  const std::optional<Plan> plan = job.plan_at(report.seconds);
  if (!plan)
    return fail("E-SENSOR", fmt::format("no value for a sensor after {:.0f} s", report.seconds),
                "errors depend on it", "give it with --set");
  auto made = TipModel::make(*plan, job.setup);
  if (!std::holds_alternative<TipModel>(made)) return true;  // the first plan of this machine was good
  model = std::move(std::get<TipModel>(made));
  return !model.use_tool(tool);
}

ToolPose Follower::pose_at(const Motion& next, double s) {
  if (next.turns()) {
    Turns turns{};
    for (std::size_t k = 0; k < 3; ++k)
      turns[k] = next.turns_start[k] + s * (next.turns_end[k] - next.turns_start[k]);
    model.stand({turns, turns, next.tcp, reader.frames().tool_offset.z()});
  }
  const Vec3 m = next.kind == MotionKind::arc ? point_at(next, s)
                                              : Vec3(next.start.at + s * (next.end.at - next.start.at));
  const TipAndAxis is = model.actual_pose(m, &report.outside);
  return {(*to_part)(is.position - report.datum), (to_part->A * is.tool_axis).normalized()};
}

void Follower::put(double s, const ToolPose& pose) {
  motion.poses.push_back(pose);
  motion.share.push_back(s);
}

/// Poses between a and b (b included) until each middle lies on the line of its neighbours.
void Follower::refine(const Motion& next, double s0, const ToolPose& a, double s1, const ToolPose& b,
                      int depth) {
  const double middle = (s0 + s1) / 2;
  const ToolPose is = pose_at(next, middle);
  if (depth > 0 && (is.tip - (a.tip + b.tip) / 2).norm() > job.tolerance) {
    refine(next, s0, a, middle, is, depth - 1);
    refine(next, middle, is, s1, b, depth - 1);
    return;
  }
  put(s1, b);
}

double Follower::seconds_of(const Motion& next) const {
  if (motion.rapid) return job.rapid_speed > 0 ? motion.length / job.rapid_speed * 60 : 0;
  if (!(next.feed > 0)) return 0;
  if (next.feed_mode == 930) return 60 / next.feed;
  // conversational programs in inches count feeds in tenths: F100 is 10 inch/min
  const double feed_inch = profile_of(job.setup)->text.conversational ? inch / 10 : inch;
  return motion.length / (next.feed * (reader.inch() ? feed_inch : mm)) * 60;
}

bool Follower::follow(const Motion& next) {
  if (next.kind == MotionKind::cycle) return follow_cycle(next);
  if (next.kind == MotionKind::nurbs)
    return fail("E-SPLINE", "a curve by control points", "what a tool leaves along it is not reckoned",
                "post it as lines");
  const bool known =
      next.start.known == kAllAxes && next.end.known == kAllAxes && next.kind != MotionKind::home;
  if (!known || !to_part) {
    connected = false;
    return true;
  }
  if (job.plan_at && next.feeds() && next.feed_mode == 950)
    return fail("E-PART-TIME", "a feed per turn of the spindle says no time", "errors depend on the time",
                "leave out --clock, or post with G94");
  has_cut = has_cut || next.feeds();
  motion = {};
  motion.line = reader.line();
  motion.rapid = !next.feeds();
  motion.connected = connected;
  motion.length = length_of(next);
  double turned = 0;
  for (std::size_t k = 0; k < 3; ++k)
    turned = std::max(turned, std::abs(next.turns_end[k] - next.turns_start[k]));
  if (!next.turns()) model.stand({next.turns_end, next.turns_end, next.tcp, reader.frames().tool_offset.z()});
  const double swept = next.kind == MotionKind::arc ? std::abs(next.arc.sweep) : 0;
  const int pieces = static_cast<int>(std::clamp(
      std::ceil(std::max({motion.length / kPiece, swept / kArcPiece, turned / kTurnPiece})), 1.0, 20000.0));
  ToolPose from = pose_at(next, 0);
  put(0, from);
  for (int k = 0; k < pieces; ++k) {
    const double s0 = static_cast<double>(k) / pieces, s1 = static_cast<double>(k + 1) / pieces;
    const ToolPose to = pose_at(next, s1);
    refine(next, s0, from, s1, to, kDeepest);
    from = to;
  }
  connected = true;
  report.beyond_travel = report.beyond_travel || model.beyond_travel(next.end.at) >= 0;
  ++report.motions;
  report.poses += motion.poses.size();
  report.seconds += seconds_of(next);
  if (!motion.rapid) report.feed_length += motion.length;
  motion.time = report.seconds;
  found(motion);
  return true;
}

/// Over each hole, to R, down, up: lines.
bool Follower::follow_cycle(const Motion& next) {
  Motion line = next;
  Vec3 at = next.start.at;
  const auto go = [&](const Vec3& to, MotionKind kind) {
    line.kind = kind;
    line.start = {at, next.start.known};
    line.end = {to, kAllAxes};
    at = to;
    return follow(line);
  };
  for (int hole = 0; hole < next.cycle.holes; ++hole) {
    const Vec3 shift = hole * next.cycle.step;
    if (!go(next.cycle.travel + shift, MotionKind::rapid) ||
        !go(next.cycle.retract + shift, MotionKind::rapid) ||
        !go(next.cycle.bottom + shift, MotionKind::line) || !go(next.cycle.clear + shift, MotionKind::rapid))
      return false;
  }
  return true;
}

bool Follower::run(const Progress& progress) {
  std::uint64_t items = 0;
  for (;;) {
    switch (reader.next()) {
      case ProgramReader::Item::end:
        return true;
      case ProgramReader::Item::refused:
        report.diagnostics.push_back(reader.refusal());
        return false;
      case ProgramReader::Item::event:
        break;
      case ProgramReader::Item::motion:
        if (reader.motion().cutter.offset != 0)
          return fail("E-CUTCOM", "cutter compensation: the program states the contour",
                      "where the cutter's centre runs beside it is the control's affair",
                      "post the tool-centre path, or say --radius D..=0 where the program states it");
        if (!place(reader.motion()) || !use_clock() || !follow(reader.motion())) return false;
        break;
    }
    if (progress && ++items % 256 == 0 &&
        !progress(reader.file().bytes_read(), reader.file().identity().size)) {
      report.end = PoseReport::End::stopped;
      return false;
    }
  }
}

}  // namespace

PoseReport program_poses(const Plan& plan, const PoseJob& job,
                         const std::function<void(const MotionPoses&)>& motion, const Progress& progress) {
  PoseReport report;
  auto model = TipModel::make(plan, job.setup);
  if (auto* fault = std::get_if<Diagnostic>(&model)) {
    report.diagnostics.push_back(std::move(*fault));
    return report;
  }
  const verifying::Rotary rotary(plan.machine());
  ProgramReader::Options options;
  options.hashed = false;
  options.skip_deletable = job.setup.block_delete == ControlSetup::BlockDelete::on;
  options.rotary = &rotary;
  auto reader = ProgramReader::open(job.path, job.name, job.setup, options);
  if (const auto* error = std::get_if<FileError>(&reader)) {
    report.diagnostics.push_back(
        {Severity::error, "E-FILE", {job.name, 0, 0, 0, {}}, error->message, "", "check the path"});
    report.end = PoseReport::End::io;
    return report;
  }
  Follower follower{job, motion, std::move(std::get<TipModel>(model)),
                    std::move(std::get<ProgramReader>(reader)), report};
  if (follower.run(progress)) report.end = PoseReport::End::done;
  const bool open =
      job.setup.block_delete == ControlSetup::BlockDelete::unknown && follower.reader.saw_deletable();
  if (report.end == PoseReport::End::done && open) {
    report.end = PoseReport::End::refused;
    report.diagnostics.push_back({Severity::error,
                                  "E-PART-SKIP",
                                  {job.name, 0, 0, 0, {}},
                                  "the program has blocks that begin with '/'",
                                  "with them and without them the part is another one",
                                  "--block-delete on | off"});
  }
  return report;
}

}  // namespace abbe
