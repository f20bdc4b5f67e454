// Lines and arcs in as many pieces as the correction along them needs.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/cl/rewriter.h"
#include "abbe/core/units.h"

namespace abbe::cl {
namespace {

constexpr double kSpacing = 5;  // mm between looks along a line
constexpr double kTurnSpacing = 2 * deg;
constexpr double kArcSpacing = 15 * deg;
constexpr int kMostSamples = 128;
constexpr int kDeepest = 10;          // 1024 pieces
constexpr double kLeastPiece = 0.05;  // mm, or
constexpr double kLeastTurn = 0.05 * deg;
constexpr double kLeastArc = 5 * deg;
constexpr double kSweepSlack = 0.05;  // rad: a written arc sweeps what the original does
constexpr double kCutterPieces = 2;   // cutter diameters that a piece under CUTCOM has at least
constexpr double kNearly = 0.9;       // of the tolerance, for motions that should stay one

/// The bytes of a record without what stands behind its last item, for every piece but the first.
std::string without_remark(const std::string& bytes) {
  const std::string eol(end_of_line(bytes).empty() ? std::string_view("\n") : end_of_line(bytes));
  const std::size_t last_line =
      bytes.size() > eol.size() ? bytes.rfind('\n', bytes.size() - eol.size() - 1) : std::string::npos;
  const std::size_t remark = bytes.find("$$", last_line == std::string::npos ? 0 : last_line);
  std::string text = bytes.substr(0, std::min(remark, bytes.size() - end_of_line(bytes).size()));
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.pop_back();
  return text + eol;
}

/// Adds the missing end of line of a file's last record, when something follows it.
std::string ended(std::string bytes) {
  if (end_of_line(bytes).empty()) bytes += '\n';
  return bytes;
}

}  // namespace

bool Rewriter::too_bent(const Record& record, double left, const char* fix) {
  findings_.refuse(record,
                   {"E-TOL",
                    fmt::format("the correction bends by {:.2f} um along this motion, {:.2f} um is allowed",
                                left / um, allowed_in_one() / um),
                    "one motion cannot follow it", fix});
  return false;
}

int Rewriter::samples(const Node& a, const Node& b) const {
  const Motion& motion = interpreter_.motion();
  // Near the singularity the rotary axes turn farther than the tool.
  double turn = turn_of(motion) * (b.s - a.s);
  for (int i = 0; i < machine_.axis_count(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (machine_.axis(i).type == AxisType::rotary)
      turn = std::max(turn, std::abs(b.place.q[k] - a.place.q[k]));
  }
  const bool arc = motion.kind == MotionKind::arc;
  const double way =
      arc ? motion.arc.sweep * (b.s - a.s) / kArcSpacing : length_of(motion) * (b.s - a.s) / kSpacing;
  return std::clamp(static_cast<int>(std::ceil(std::min(way + turn / kTurnSpacing, 1e3))), arc ? 4 : 2,
                    kMostSamples);
}

/// The largest distance between the path that the file `written` makes the machine cut, and the original.
double Rewriter::left_between(const Motion& written, const Node& a, const Node& b) const {
  const int count = samples(a, b);
  double most = 0;
  for (int i = 1; i < count; ++i) {
    const double t = static_cast<double>(i) / count, s = a.s + t * (b.s - a.s);
    const PoseField::Place place = field_.between(pose_at(interpreter_.motion(), s), a.place, b.place, t);
    const auto left = field_.left_at(place, pose_at(written, t));
    if (!left || place.trouble != PoseField::Trouble::none) return 1e9;
    most = std::max(most, left->norm());
  }
  return most;
}

bool Rewriter::node_between(const Record& record, const Node& a, const Node& b, Node& middle) {
  middle.s = 0.5 * (a.s + b.s);
  middle.place = field_.between(pose_at(interpreter_.motion(), middle.s), a.place, b.place, 0.5);
  if (!place_is_good(record, middle.place)) return false;
  NumberEdit edit(record);
  return solve(record, edit, a.written.tip, middle);
}

/// Motions that should stay one may use what else is left for solving; the others half the tolerance.
double Rewriter::allowed_in_one() const {
  return (stays_one() || interpreter_.motion().cutter_compensated ? kNearly : 0.5) * job_.tolerance;
}

bool Rewriter::stays_one() const {
  const Motion& motion = interpreter_.motion();
  return !motion.may_split || motion.incremental || interpreter_.feed().mode == FeedMode::inverse_time;
}

/// Whether a motion that leaves `left` may be cut into pieces of this part of it; refused if not.
/// A cutter-compensating control intersects neighbouring pieces: short ones may vanish inside a corner.
bool Rewriter::may_halve(const Record& record, double left, double part, int depth) {
  const Motion& motion = interpreter_.motion();
  const double length = part * length_of(motion);
  if (stays_one())
    return too_bent(record, left, "post shorter motions (GOTO, feeds per minute) there, or --tolerance-um");
  if (depth >= kDeepest || (length < kLeastPiece && part * turn_of(motion) < kLeastTurn))
    return too_bent(record, left,
                    "the correction has a step there: check the error tables, or --tolerance-um");
  if (motion.cutter_compensated &&
      !(interpreter_.cutter_diameter() > 0 && length >= kCutterPieces * interpreter_.cutter_diameter())) {
    findings_.refuse(
        record,
        {"E-CUTCOM",
         fmt::format("the correction bends by {:.2f} um, and pieces of {:.2f} mm are too short under CUTCOM",
                     left / um, length),
         "pieces shorter than two cutter diameters may vanish inside a corner of the offset path",
         "--tolerance-um, or post the tool-centre path"});
    return false;
  }
  report_.shortest_split = report_.shortest_split == 0 ? length : std::min(report_.shortest_split, length);
  return true;
}

bool Rewriter::line_pieces(const Record& record, const Node& a, const Node& b, int depth,
                           std::vector<Node>& ends) {
  Motion written;
  written.start = a.written;
  written.end = b.written;
  const double left = left_between(written, a, b);
  if (left <= allowed_in_one()) {
    ends.push_back(b);
    return true;
  }
  if (!may_halve(record, left, 0.5 * (b.s - a.s), depth)) return false;
  Node middle;
  return node_between(record, a, b, middle) && line_pieces(record, a, middle, depth + 1, ends) &&
         line_pieces(record, middle, b, depth + 1, ends);
}

bool Rewriter::line_motion(const Record& record, const Node& end, std::string& out) {
  Node start = *last_;
  start.s = 0;
  std::vector<Node> ends;
  if (!line_pieces(record, start, end, 0, ends)) return false;
  std::string text;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    // The remark stays with the first piece; the last one ends like the record did.
    std::string piece = i == 0 ? ends[i].text : without_remark(ends[i].text);
    if (i + 1 < ends.size())
      piece = ended(std::move(piece));
    else if (end_of_line(record.bytes).empty() && i > 0)
      piece.pop_back();
    text += piece;
  }
  if (ends.size() > 1) ++report_.blocks.split;
  if (text == record.bytes)
    ++report_.blocks.passed;
  else
    ++report_.blocks.rewritten;
  trace(record, end,
        ends.size() > 1 ? fmt::format("split into {} lines", ends.size()) : "the end is corrected", text);
  write(text, out);
  return true;
}

// A centre as far from both written ends: on the plane through the middle of their chord, at right angles to
// it.
double Rewriter::fit_arc(const Node& a, const Node& b, bool through_middle, Vec3& centre) const {
  const Motion& motion = interpreter_.motion();
  const Vec3& n = motion.arc.normal;
  const double half = 0.5 * (a.s + b.s), sweep = motion.arc.sweep * (b.s - a.s);
  const Vec3 start = a.written.tip, end = b.written.tip;
  // The middle, moved like the path around it.
  const PoseField::Place middle = field_.between(pose_at(motion, half), a.place, b.place, 0.5);
  const PoseField::Answer moved = field_.corrected_tip(middle, a.written.axis, middle.pose.tip + correction_);
  if (moved.trouble != PoseField::Trouble::none) return 1e9;
  const Vec3 original = motion.arc.centre + n * (motion.arc.rise * a.s);
  const Vec3 guess = original + 0.5 * ((moved.tip - middle.pose.tip) +
                                       0.5 * ((start - a.place.pose.tip) + (end - b.place.pose.tip)));
  Vec3 chord = end - start;
  chord -= n * n.dot(chord);
  const Vec3 mid = 0.5 * (start + end);
  if (chord.norm() < 1e-9) {
    centre = guess;
  } else {
    const Vec3 e = n.cross(chord.normalized());
    Vec3 out = guess - mid;
    double along = e.dot(out);
    if (through_middle) {
      // |mid + t e - start|^2 = |mid + t e - m|^2, in the plane of the circle
      const Vec3 m = moved.tip - mid - n * n.dot(moved.tip - mid),
                 from = start - mid - n * n.dot(start - mid);
      const double below = 2 * (e.dot(m) - e.dot(from));
      if (std::abs(below) > 1e-9) along = (m.squaredNorm() - from.squaredNorm()) / below;
    }
    // What the original's centre is off this plane, by its digits, it stays.
    const Vec3 was = pose_at(motion, b.s).tip - pose_at(motion, a.s).tip,
               was_chord = (was - n * n.dot(was)).normalized();
    const double off = was_chord.dot(original - 0.5 * (a.place.pose.tip + b.place.pose.tip));
    centre = mid + along * e + off * chord.normalized();
  }
  centre += n * n.dot(start - centre);  // at the height of the start
  Motion written;
  written.kind = MotionKind::arc;
  written.start = a.written;
  written.end = b.written;
  written.arc = make_arc(centre, n, start, end, chord.norm() < 1e-9 ? interpreter_.arc_turns() : 1);
  if (std::abs(written.arc.sweep - sweep) > kSweepSlack) return 1e9;
  return left_between(written, a, b);
}

bool Rewriter::arc_pieces(const Record& record, const Node& a, const Node& b, int depth,
                          std::vector<ArcPiece>& pieces) {
  const Motion& motion = interpreter_.motion();
  ArcPiece piece{b, {}};
  double left = fit_arc(a, b, false, piece.centre);
  if (left > allowed_in_one()) {
    Vec3 other;
    const double by_points = fit_arc(a, b, true, other);
    if (by_points < left) {
      left = by_points;
      piece.centre = other;
    }
  }
  if (left <= allowed_in_one()) {
    pieces.push_back(std::move(piece));
    return true;
  }
  const double part = 0.5 * (b.s - a.s);
  if (motion.arc.sweep * part < kLeastArc)
    return too_bent(record, left, "post the arc as points, or --tolerance-um");
  if (!may_halve(record, left, part, depth)) return false;
  Node middle;
  return node_between(record, a, b, middle) && arc_pieces(record, a, middle, depth + 1, pieces) &&
         arc_pieces(record, middle, b, depth + 1, pieces);
}

bool Rewriter::arc(const Record& record, const Node& end, std::string& out) {
  ++report_.arcs_in;
  Node start = *last_;
  start.s = 0;
  std::vector<ArcPiece> pieces;
  if (!arc_pieces(record, start, end, 0, pieces)) return false;
  report_.arcs_out += pieces.size();
  if (pieces.size() > 1) ++report_.blocks.split;
  write_arc(record, pieces, out);
  return true;
}

std::string Rewriter::circle_bytes(const ArcPiece& piece, const Node& start, bool first) const {
  const Record& record = held_.front();
  const Motion& motion = interpreter_.motion();
  const Frame& frame = interpreter_.frame();
  const Vec3& n = motion.arc.normal;
  const int decimals = frame.unit == inch ? digits_.length + 1 : digits_.length;
  NumberEdit edit(record);
  // The file's centre may stand at another height than the start: it keeps that distance.
  const Vec3 stated(record.items[0].value, record.items[1].value, record.items[2].value);
  const double height = n.dot(frame.to_program(stated) - motion.start.tip);
  const Vec3 numbers = frame.to_numbers(piece.centre + height * n);
  for (std::size_t k = 0; k < 3; ++k) edit.set(k, numbers[static_cast<Eigen::Index>(k)], decimals);
  if (record.leading_numbers() >= 7) {
    const Vec3 out = start.written.tip - piece.centre;
    // the radius stated, and what it changed by: its digits are the file's
    const double grown = ((out - n * n.dot(out)).norm() - motion.arc.start_radius) / frame.unit;
    edit.set(6, record.items[6].value + std::copysign(grown, grown * record.items[6].value), decimals);
  }
  return first ? edit.bytes() : without_remark(edit.bytes());
}

void Rewriter::write_arc(const Record& record, const std::vector<ArcPiece>& pieces, std::string& out) {
  std::string text, before;
  for (const Record& held : held_) before += held.bytes;
  before += record.bytes;
  Node start = *last_;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    text += ended(circle_bytes(pieces[i], start, i == 0));
    if (i == 0) {
      for (std::size_t k = 1; k < held_.size(); ++k) text += held_[k].bytes;
    }
    std::string piece = i == 0 ? pieces[i].end.text : without_remark(pieces[i].end.text);
    if (i + 1 < pieces.size())
      piece = ended(std::move(piece));
    else if (end_of_line(record.bytes).empty() && i > 0)
      piece.pop_back();
    text += piece;
    start = pieces[i].end;
  }
  if (text == before)
    ++report_.blocks.passed;
  else
    ++report_.blocks.rewritten;
  trace(record, pieces.back().end,
        pieces.size() > 1 ? fmt::format("an arc in {} arcs", pieces.size()) : "an arc stays one arc", text);
  write(text, out);
}

}  // namespace abbe::cl
