#include "abbe/cl/rewriter.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "abbe/core/units.h"

namespace abbe::cl {
namespace {

constexpr std::string_view kMark = "ABBE COMPENSATED";
constexpr std::uint64_t kMarkLines = 40;  // our mark stands in the header, never deeper
constexpr double kGradientBase = 0.05;    // mm: between closer points rounding would decide

bool holds_line(const Record& record, std::uint64_t line) {
  return line >= record.line && line < record.line + record.line_count;
}

std::string axes_text(const Machine& machine, const Commands& q) {
  std::string text;
  for (int i = 0; i < machine.axis_count(); ++i)
    text += fmt::format("{}{} {:.5f}", i == 0 ? "" : "  ", machine.axis(i).name,
                        q[static_cast<std::size_t>(i)] / machine.axis_unit(i));
  return text;
}

}  // namespace

Rewriter::Rewriter(const Plan& plan, AxisSet free, const ClJob& job, RewriteReport& report)
    : job_(job),
      report_(report),
      machine_(plan.machine()),
      findings_(job.name),
      interpreter_(job.conventions, job.setup.loaded_tool),
      placement_(placement_of(plan, job.setup.work_offsets[0])),
      field_(plan, placement_, job.probed_datum, free, job.start) {}

void Rewriter::write(std::string_view bytes, std::string& out) {
  out += bytes;
  report_.lines_out += static_cast<std::uint64_t>(std::count(bytes.begin(), bytes.end(), '\n'));
  if (!bytes.empty() && bytes.back() != '\n') ++report_.lines_out;
}

void Rewriter::line(std::string_view bytes, std::uint64_t number, bool too_long, std::string& out) {
  if (!header_written_) {
    header_written_ = true;
    const std::string_view eol = end_of_line(bytes).empty() ? std::string_view("\n") : end_of_line(bytes);
    for (const std::string& text : job_.header) write(fmt::format("$$ {}{}", text, eol), out);
  }
  const auto state = reader_.add(bytes, number);
  if (state == RecordReader::State::wants_more && !too_long) return;
  if (state == RecordReader::State::error) {
    const RecordError& error = reader_.error();
    findings_.add(Severity::error, reader_.record(), error.begin, error.length,
                  {error.code.c_str(), error.message, error.why, error.fix});
    return;
  }
  if (too_long) {
    findings_.refuse(reader_.record(),
                     {"E-LINELEN", "a line of more than 64 KiB", "no writer of CL data makes such lines",
                      "check that this is a CL file"});
    return;
  }
  record(out);
}

void Rewriter::finish(std::string& out) {
  if (reader_.finish() == RecordReader::State::error) {
    const RecordError& error = reader_.error();
    findings_.add(Severity::error, reader_.record(), error.begin, error.length,
                  {error.code.c_str(), error.message, error.why, error.fix});
  }
  if (!held_.empty()) {
    findings_.refuse(held_.front(), {"E-ARC", "a circle without the GOTO that ends it",
                                     "the circle has no end", "write the GOTO behind it"});
  }
  for (const Record& record : held_) write(record.bytes, out);
  held_.clear();
}

void Rewriter::check_mark(const Record& record) {
  const std::size_t mark = record.bytes.find(kMark);
  if (record.line > kMarkLines || mark == std::string::npos) return;
  report_.compensated_input = true;
  findings_.add(Severity::error, record, mark, kMark.size(),
                {"E-COMPENSATED", "this file has been compensated already",
                 "compensating twice doubles the correction", "use the original file"});
}

void Rewriter::record(std::string& out) {
  const Record& record = reader_.record();
  if (record.is_remark()) check_mark(record);
  switch (interpreter_.take(record, findings_)) {
    case Interpreter::Outcome::held:
      held_.push_back(record);
      return;
    case Interpreter::Outcome::motion:
      ++report_.blocks.motion;
      if (!motion(record, out)) last_.reset();
      held_.clear();
      return;
    case Interpreter::Outcome::refused:
      held_.clear();
      last_.reset();
      return;
    case Interpreter::Outcome::copied:
      break;
  }
  if (!held_.empty()) {
    held_.push_back(record);
    return;
  }
  if (holds_line(record, job_.trace_line)) trace(record, {}, "not a motion: copied", record.bytes);
  write(record.bytes, out);
}

bool Rewriter::use_tool(const Record& record) {
  if (tool_used_ && tool_ == interpreter_.tool()) return true;
  tool_used_ = true;
  tool_ = interpreter_.tool();
  const GaugeLength gauge = gauge_length(job_.setup, machine_, tool_);
  if (gauge.touch_off && machine_.has_angular_errors()) {
    findings_.refuse(
        record,
        {"E-GAUGE", fmt::format("the length of tool {} in the tool table is negative", tool_.value_or(-1)),
         "rotation errors act with the tool's length, and this is a touch-off value",
         fmt::format("--gauge T{}=..", tool_.value_or(-1))});
    return false;
  }
  if (gauge.source == GaugeLength::Source::machine_file && tool_ && machine_.has_angular_errors()) {
    findings_.warn(record,
                   {"W-GAUGE",
                    fmt::format("the length of tool {} is not known: the machine file's {:.3f} mm is used",
                                *tool_, gauge.length),
                    "rotation errors act with the tool's length",
                    fmt::format("--gauge T{}=.., or --tools FILE", *tool_)});
  }
  field_.set_tool(tool_of(machine_, gauge.length));
  correction_ = Vec3::Zero();
  return true;
}

bool Rewriter::refuse(const Record& record, PoseField::Trouble trouble, const ToolPose& pose, int axis) {
  using Trouble = PoseField::Trouble;
  const std::string at =
      fmt::format("tip {:.3f} {:.3f} {:.3f} mm, tool axis {:.6f} {:.6f} {:.6f}", pose.tip.x(), pose.tip.y(),
                  pose.tip.z(), pose.axis.x(), pose.axis.y(), pose.axis.z());
  report_.out_of_volume = report_.out_of_volume || trouble == Trouble::outside || trouble == Trouble::travel;
  switch (trouble) {
    case Trouble::none:
      return true;
    case Trouble::unreachable:
      findings_.refuse(record, {"E-REACH", "the machine cannot bring the tool there: " + at,
                                "its axes do not turn the tool that way, or not within their travels",
                                "check the machine file, the part's place (--offset) and the tool axis"});
      return false;
    case Trouble::failed:
      findings_.refuse(record, {"E-SOLVE", "no correction was found: " + at,
                                "the errors of the machine file are too large or not finite there",
                                "check the machine file with `abbe predict`"});
      return false;
    case Trouble::outside:
      findings_.refuse(record, {"E-VOL", "outside the calibrated volume: " + at,
                                "beyond the measured range the errors are not known",
                                "check the part's place (--offset) and the temperatures, or measure a "
                                "larger volume"});
      return false;
    case Trouble::travel:
      break;
  }
  findings_.refuse(record,
                   {"E-TRAVEL", fmt::format("outside the travel of {}: {}", machine_.axis(axis).name, at),
                    "the control would stop there, or the machine file's range is wrong",
                    "check the part's place (--offset) and `range` in the machine file"});
  return false;
}

bool Rewriter::place_is_good(const Record& record, const PoseField::Place& place) {
  if (!refuse(record, place.trouble, place.pose, place.axis)) return false;
  if (!place.singular || !interpreter_.motion().axis_free) return true;
  ++report_.held_blocks;
  if (!singular_warned_) {
    singular_warned_ = true;
    findings_.warn(record, {"W-SINGULAR",
                            "the tool axis is within 1 deg of the singularity of the rotary axes: it is kept "
                            "here, the tip is corrected",
                            "there a small tilt needs a large turn",
                            "tilt the part or the tool by a few degrees if the direction matters"});
  }
  return true;
}

/// The tool axis to write: corrected, as it stands, or the one that the record before left.
void Rewriter::write_axis(const Record& record, NumberEdit& edit, Node& node) const {
  const Motion& motion = interpreter_.motion();
  const Frame& frame = interpreter_.frame();
  if (!motion.axis_given) {
    node.written.axis = last_ ? last_->written.axis : node.place.pose.axis;
    return;
  }
  const Vec3 stated(record.items[3].value, record.items[4].value, record.items[5].value);
  Vec3 seen = stated;
  const bool on_arc = motion.kind == MotionKind::arc && last_;
  if (on_arc || motion.axis_free || node.s != 1) {
    // An arc keeps the axis that is written at its start, and its own digits of it.
    const Vec3 turned = on_arc             ? Vec3(last_->written.axis - last_->place.pose.axis)
                        : motion.axis_free ? Vec3(field_.corrected_axis(node.place) - node.place.pose.axis)
                                           : Vec3(Vec3::Zero());
    // as long as the record's own vector: its digits are not those of a unit vector
    const Mat3 back = stated.norm() * frame.rotation.transpose();
    const Vec3 numbers = (node.s == 1 ? stated : Vec3(back * node.place.pose.axis)) + back * turned;
    for (std::size_t k = 0; k < 3; ++k)
      seen[static_cast<Eigen::Index>(k)] =
          edit.set(3 + k, numbers[static_cast<Eigen::Index>(k)], digits_.axis);
  }
  node.written.axis = (frame.rotation * seen).normalized();
}

/// Fills in what is written for a pose. `from`: GODLTA only, where the written path stands.
bool Rewriter::solve(const Record& record, NumberEdit& edit, const Vec3& from, Node& node) {
  const Motion& motion = interpreter_.motion();
  const Frame& frame = interpreter_.frame();
  write_axis(record, edit, node);
  const bool closed =
      last_ && motion.kind == MotionKind::arc && node.s == 1 && motion.end.tip == motion.start.tip;
  PoseField::Answer answer = field_.corrected_tip(
      node.place, node.written.axis, closed ? last_->written.tip : Vec3(node.place.pose.tip + correction_));
  if (!refuse(record, answer.trouble, node.place.pose, answer.axis)) return false;
  if (closed) answer.tip = last_->written.tip;  // a whole turn ends exactly where it begins
  node.q = answer.q;
  const int decimals = frame.unit == inch ? digits_.length + 1 : digits_.length;
  const Vec3 numbers = motion.incremental
                           ? Vec3(frame.rotation.transpose() * (answer.tip - from) / frame.unit)
                           : frame.to_numbers(answer.tip);
  Vec3 seen;
  for (std::size_t k = 0; k < 3; ++k)
    seen[static_cast<Eigen::Index>(k)] = edit.set(k, numbers[static_cast<Eigen::Index>(k)], decimals);
  node.written.tip =
      motion.incremental ? Vec3(from + frame.rotation * (frame.unit * seen)) : frame.to_program(seen);
  node.text = edit.bytes();
  return true;
}

bool Rewriter::end_node(const Record& record, Node& node) {
  const Motion& motion = interpreter_.motion();
  node.s = 1;
  node.place = field_.follow(motion.end);
  if (!place_is_good(record, node.place)) return false;
  NumberEdit edit(record);
  return solve(record, edit, last_ ? last_->written.tip : motion.start.tip, node) && note(record, node);
}

bool Rewriter::note(const Record& record, const Node& node) {
  const Vec3 c = node.written.tip - node.place.pose.tip;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (std::abs(c[k]) <= report_.max_correction[i]) continue;
    report_.max_correction[i] = std::abs(c[k]);
    report_.max_line[i] = record.line;
  }
  if (c.norm() > job_.max_correction) {
    findings_.refuse(record, {"E-CORRECTION",
                              fmt::format("the correction is {:.1f} um, {:.0f} um is the limit",
                                          c.norm() / um, job_.max_correction / um),
                              "so large a correction is usually a wrong unit, sign or offset",
                              "check the machine file; --max-correction-um raises the limit"});
    return false;
  }
  // The tip only: where the tool turns, the correction of the tip may change without any way.
  const Motion& motion = interpreter_.motion();
  const double way = (motion.end.tip - motion.start.tip).norm();
  if (last_ && motion.start_known && way > kGradientBase && turn_of(motion) == 0) {
    const double gradient = (c - (last_->written.tip - last_->place.pose.tip)).norm() / way;
    report_.max_gradient = std::max(report_.max_gradient, gradient);
    if (gradient > job_.max_gradient) {
      findings_.refuse(record, {"E-GRADIENT",
                                fmt::format("the correction changes by {:.2f} mm per m, {:.2f} is the limit",
                                            gradient * 1e3, job_.max_gradient * 1e3),
                                "no machine is that crooked: a table has a step, or a unit is wrong",
                                "check the error tables of the machine file"});
      return false;
    }
  }
  correction_ = c;
  return true;
}

bool Rewriter::motion(const Record& record, std::string& out) {
  const Motion& motion = interpreter_.motion();
  if (!use_tool(record)) return false;
  if (!motion.start_known) last_.reset();
  Node end;
  if (!end_node(record, end)) return false;
  bool good = true;
  if (motion.kind == MotionKind::arc) {
    good = last_ && arc(record, end, out);
  } else if (motion.kind == MotionKind::line && last_) {
    good = line_motion(record, end, out);
  } else {
    good = motion.kind != MotionKind::hole || hole(record, end);
    trace(record, end,
          motion.kind == MotionKind::hole   ? "a hole: moved as a whole"
          : motion.kind == MotionKind::from ? "FROM: where the tool stands"
                                            : "the end is corrected",
          end.text);
    if (end.text == record.bytes)
      ++report_.blocks.passed;
    else
      ++report_.blocks.rewritten;
    write(end.text, out);
  }
  end.s = 0;
  end.text.clear();
  last_ = std::move(end);
  return good;
}

/// The tool is moved as a whole: the correction must not change along it.
bool Rewriter::hole(const Record& record, const Node& node) {
  const Motion& motion = interpreter_.motion();
  for (const double reach : {motion.above, -motion.below}) {
    if (reach == 0) continue;
    const ToolPose nominal{motion.end.tip + reach * motion.end.axis, motion.end.axis};
    const ToolPose written{node.written.tip + reach * node.written.axis, node.written.axis};
    const PoseField::Place place = field_.between(nominal, node.place, node.place, 0);
    if (!refuse(record, place.trouble, nominal, place.axis)) return false;
    const auto left = field_.left_at(place, written);
    if (!left) return refuse(record, PoseField::Trouble::unreachable, nominal, 0);
    report_.cycle_residual = std::max(report_.cycle_residual, left->norm());
    if (left->norm() <= job_.tolerance) continue;
    findings_.refuse(
        record,
        {"E-CYCLE",
         fmt::format("the correction changes by {:.2f} um within this hole, {:.2f} um is the tolerance",
                     left->norm() / um, job_.tolerance / um),
         "a cycle is moved as a whole", "post the hole as GOTO records, or --tolerance-um"});
    return false;
  }
  return true;
}

void Rewriter::trace(const Record& record, const Node& end, std::string_view decision,
                     std::string_view written) {
  if (job_.trace_line == 0 || !holds_line(record, job_.trace_line)) return;
  BlockTrace t;
  t.frame = "CL data";
  t.tool = tool_;
  t.gauge_length = gauge_length(job_.setup, machine_, tool_).length;
  t.frame_origin = placement_.origin;
  t.datum = field_.datum();
  t.start = (last_ ? last_->place : end.place).pose.tip;
  t.end = end.place.pose.tip;
  t.correction = end.written.tip - t.end;
  const Vec3& axis = end.written.axis;
  t.decision = fmt::format("{}; tool axis {:.8f} {:.8f} {:.8f}; axes {} instead of {}", decision, axis.x(),
                           axis.y(), axis.z(), axes_text(machine_, end.q), axes_text(machine_, end.place.q));
  const auto text = [](std::string_view bytes) {
    return std::string(bytes.substr(0, bytes.size() - end_of_line(bytes).size()));
  };
  t.before = text(record.bytes);
  t.after = text(written);
  report_.trace = std::move(t);
}

}  // namespace abbe::cl
