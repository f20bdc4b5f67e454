#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"

namespace abbe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kLooksPerTurn = 24;
constexpr int kFewestLooks = 4;
// Places along an arc are never farther apart, mm.
constexpr double kLookSpacing = 10;
constexpr int kMostLooks = 400;
constexpr int kMostPieces = 4096;
// The output must turn as far as the original, rad: a rounded end on the wrong side would make a full turn.
constexpr double kSweepSlack = 0.02;
// A radius rounded to the last digit moves the centre by R / h: beyond this chord/2R it is written as a centre.
constexpr double kLargestRadiusForm = 0.94;
constexpr double kUnchanged = 1e-9;  // mm
// LinuxCNC (mm): radii at both ends differ by more than 100 times this, or by more than this and 0.1 %.
constexpr double kCentreTolerance = 0.0282842712474619;  // 2 * 0.01 * sqrt(2)
constexpr double kSpiralTolerance = 1e-3;

}  // namespace

std::optional<Arc> Rewriter::nominal_arc(const Move& move, const Vec3& p0, const Vec3& p1) {
  const int a = plane_axes(modal_.plane)[0], b = plane_axes(modal_.plane)[1];
  static_cast<void>(move);
  const bool clockwise = instruction_.motion == 20;
  const Word* r = instruction_.find(block_, 'R');
  const std::array<const Word*, 3> centre_word = {instruction_.find(block_, 'I'), instruction_.find(block_, 'J'), instruction_.find(block_, 'K')};
  const Word* wa = centre_word[static_cast<std::size_t>(a)];
  const Word* wb = centre_word[static_cast<std::size_t>(b)];
  const double unit = modal_.unit();
  const auto bad = [&](const std::string& what, const char* why, const char* fix) {
    refuse_block("E-ARC", what, why, fix);
    return std::nullopt;
  };
  for (int k = 0; k < 3; ++k) {
    if (k != a && k != b && centre_word[static_cast<std::size_t>(k)]) {
      return bad(fmt::format("{} is not in the plane of this arc", "IJK"[k]), "the control refuses it", "check G17, G18, G19");
    }
  }
  int turns = 1;
  if (const Word* p = instruction_.find(block_, 'P')) {
    if (p->value < 1 || p->value != std::floor(p->value) || p->value > 1000) return bad("P of an arc is a number of turns, 1 to 1000", "the path is not defined", "correct P");
    turns = static_cast<int>(p->value);
  }
  double ca = 0, cb = 0;
  if (r) {
    if (wa || wb) return bad("an arc with R and with I J K", "the control refuses it", "keep one form");
    const auto centre = centre_of_radius(modal_.plane, p0, p1, r->value * unit, clockwise);
    if (!centre) return bad(fmt::format("no arc of radius {} joins the ends", r->value), "the path is not defined", "check R and the end point");
    ca = centre->a;
    cb = centre->b;
  } else {
    if (!wa && !wb) return bad("an arc without I J K and without R", "the path is not defined", "add the centre");
    if (modal_.absolute_centre && (!wa || !wb)) return bad("G90.1 needs both centre words", "the path is not defined", "add the missing one");
    ca = (wa ? wa->value * unit : 0.0) + (modal_.absolute_centre ? 0.0 : p0[a]);
    cb = (wb ? wb->value * unit : 0.0) + (modal_.absolute_centre ? 0.0 : p0[b]);
  }
  const auto arc = arc_about(modal_.plane, p0, p1, ca, cb, clockwise, turns);
  if (!arc) return bad("an arc of radius zero", "the path is not defined", "check the centre");
  const double difference = std::abs(arc->r1 - arc->r0);
  if (difference > 100 * kCentreTolerance || (difference > kCentreTolerance && difference > kSpiralTolerance * std::max(arc->r0, arc->r1))) {
    return bad(fmt::format("the radius is {:.4f} mm at the start and {:.4f} mm at the end", arc->r0, arc->r1), "the control refuses it", "check the centre words");
  }
  return arc;
}

// Where the end will stand once its words are rounded: as `command` will write them.
Vec3 Rewriter::rounded_end(const Vec3& want, const Vec3& p_out, bool first) const {
  Vec3 end = p_out;
  for (int k = 0; k < 3; ++k) {
    double base = 0;
    const Value value = axis_value(k, want, p_out, first, base);
    if (value.written || (first && axis_word(k))) end[k] = base + value.number * modal_.unit();
  }
  return end;
}

// The value of a centre word; a G91.1 word that is absent is zero.
Rewriter::Value Rewriter::centre_value(int k, double centre, const Vec3& start, bool first, double& base) const {
  const Word* named = instruction_.find(block_, "IJK"[k]);
  const Word* word = first ? named : nullptr;
  base = modal_.absolute_centre ? 0.0 : start[k];
  const double wanted = (centre - base) / modal_.unit();
  if (modal_.absolute_centre && !word) return {rounded(wanted, decimals_of(named)), true};
  return value_for(wanted, word, 0.0, decimals_of(named));
}

bool Rewriter::fit_piece(const Arc& nominal, double s0, double s1, const Vec3& start, bool whole, ArcPiece& piece) {
  const Arc part = piece_of(nominal, s0, s1);
  const int a = plane_axes(modal_.plane)[0], b = plane_axes(modal_.plane)[1];
  const auto looks = std::clamp(static_cast<int>(std::ceil(std::max(std::abs(part.sweep) / kTurn * kLooksPerTurn, part.length() / kLookSpacing))), kFewestLooks, kMostLooks);
  targets_.clear();
  for (int k = 1; k <= looks; ++k) {
    const double s = static_cast<double>(k) / looks;
    const Vec3 at = in_.frames.to_machine(part.at(s));
    const auto c = correction_at(at, withheld_, approach_);
    if (!c) return false;
    targets_.push_back({s, out_.frames.to_program(at + *c)});
  }
  piece.s0 = s0;
  piece.s1 = s1;
  // A full circle ends exactly where it starts.
  const Vec3 nominal_start = part.at(0), nominal_end = part.at(1);
  const bool closed = std::hypot(nominal_end[a] - nominal_start[a], nominal_end[b] - nominal_start[b]) < 1e-9;
  piece.end = targets_.back().point;
  if (closed) {
    piece.end[a] = start[a];
    piece.end[b] = start[b];
  }
  Vec3 end = rounded_end(piece.end, start, s0 == 0);
  if (!closed && end[a] == start[a] && end[b] == start[b]) {
    // The rounded end fell on the start, which would be a full circle: one last digit onwards along the chord.
    const int along = std::abs(nominal_end[a] - nominal_start[a]) >= std::abs(nominal_end[b] - nominal_start[b]) ? a : b;
    const double digit = 2 * half_digit(decimals_of(axis_word(along))) * modal_.unit();
    piece.end[along] = start[along] + (nominal_end[along] > nominal_start[along] ? digit : -digit);
    end = rounded_end(piece.end, start, s0 == 0);
  }
  if (closed != (end[a] == start[a] && end[b] == start[b])) return false;
  const bool clockwise = nominal.sweep < 0;
  const int turns = whole ? std::max(1, static_cast<int>(std::ceil(std::abs(nominal.sweep) / kTurn - 1e-9))) : 1;
  const Word* r = instruction_.find(block_, 'R');
  const auto holds = [&](const Centre& centre) {
    const auto arc = arc_about(modal_.plane, start, end, centre.a, centre.b, clockwise, turns);
    if (!arc || std::abs(arc->sweep - part.sweep) > kSweepSlack) return false;
    const double mismatch = std::abs(arc->r1 - arc->r0), spiral = std::abs(part.r1 - part.r0);
    if (mismatch > spiral + kCentreTolerance / 2) return false;
    return distance_to(*arc, targets_) <= interpolation_;
  };
  piece.keeps_radius = false;
  if (r && whole) {
    const double chord = std::hypot(end[a] - start[a], end[b] - start[b]);
    const auto centre = centre_of_radius(modal_.plane, start, end, r->value * modal_.unit(), clockwise);
    // Ends that did not change mean what they meant, however badly R says it.
    const bool unchanged = (start - nominal_start).norm() < kUnchanged && (end - nominal_end).norm() < kUnchanged;
    const bool well_said = chord / (2 * std::abs(r->value * modal_.unit())) <= kLargestRadiusForm;
    if (centre && (unchanged || well_said) && holds(*centre)) {
      piece.keeps_radius = true;
      return true;
    }
  }
  const Centre fitted = fit_centre(part, start, end, targets_);
  // as its words will be rounded
  const auto as_written = [&](int k, double centre) {
    double base = 0;
    const Value value = centre_value(k, centre, start, s0 == 0, base);
    return base + value.number * modal_.unit();
  };
  piece.centre = {as_written(a, fitted.a), as_written(b, fitted.b)};
  return holds(piece.centre);
}

void Rewriter::command_centre(const ArcPiece& piece, const Vec3& start, bool first, std::string* extra) {
  const int a = plane_axes(modal_.plane)[0], b = plane_axes(modal_.plane)[1];
  if (piece.keeps_radius) return;
  if (const Word* r = instruction_.find(block_, 'R'); r && first) edit_.remove(*r);
  for (const int k : {a, b}) {
    double base = 0;
    const Word* named = instruction_.find(block_, "IJK"[k]);
    const Value value = centre_value(k, k == a ? piece.centre.a : piece.centre.b, start, first, base);
    if (value.written) put("IJK"[k], first ? named : nullptr, value.number, decimals_of(named), first, extra);
  }
  // Both words zero would leave the block without a centre.
  if (!modal_.absolute_centre && !first && extra->find_first_of("IJK") == std::string::npos) *extra += fmt::format(" {}0.0", "IJK"[a]);
}

bool Rewriter::arc(const Move& move, std::string& out) {
  if (!feed_allowed(move)) return false;  // knows its start, and so its end
  if (in_.frames.rotated() && (modal_.plane != Plane::xy || (withheld_ & 3u))) {
    refuse_block("E-ROTATION", "an arc out of the XY plane in a rotated work offset", "it is not an arc of the machine's axes", "set the offset without rotation");
    return false;
  }
  if (job_.reversal && field_.depends_on_direction()) {
    refuse_block("E-REVERSAL", "lost motion along an arc changes where an axis turns round", "it is taken up on straight moves only", "leave --reversal away: the mean is compensated and the lost motion reported");
    return false;
  }
  const Vec3 p0 = in_.frames.to_program(move.m0);
  const Vec3 p1 = in_.frames.to_program(move.m1);
  const auto nominal = nominal_arc(move, p0, p1);
  if (!nominal) return false;
  ++report_.arcs_in;
  if (withheld_ != 0) {
    const auto full = correction_at(move.m1, 0, approach_);
    if (!full) return false;
    for (int k = 0; k < 3; ++k) {
      if (!(withheld_ & (1u << k)) || std::abs((*full)[k]) <= job_.tolerance) continue;
      refuse_block("E-POS", fmt::format("an arc while {} stands where G53 put it, without its correction", "XYZ"[k]),
                   "a word is not added to an axis that the program commanded in machine coordinates", "command the axis in the work offset first");
      return false;
    }
  }
  const auto c1 = correction_at(move.m1, withheld_, approach_);
  if (!c1) return false;
  note_correction(move.m1, *c1);

  Vec3 p_out = out_.p();
  std::string extra, tail;
  double s0 = 0;
  int written = 0;
  const int turns = std::max(1, static_cast<int>(std::ceil(std::abs(nominal->sweep) / kTurn - 1e-9)));
  const std::string_view inner_eol = file_eol_.empty() ? std::string_view("\n") : std::string_view(file_eol_);
  while (s0 < 1) {
    ArcPiece piece;
    bool fitted = false;
    // As few equal pieces of what is left as hold; several turns are either one block or unrolled.
    for (int k = 1; k <= kMostPieces && !fitted; k = k < 8 ? k + 1 : k + k / 4) {
      const double s1 = k == 1 ? 1.0 : s0 + (1 - s0) / k;
      const bool whole = s0 == 0 && k == 1;
      if (!whole && std::abs(nominal->sweep) * (s1 - s0) > kTurn * 0.98) continue;
      fitted = fit_piece(*nominal, s0, s1, p_out, whole, piece);
      if (!fitted && findings_.refused()) return false;
    }
    if (!fitted) {
      refuse_block("E-TOL", "no arcs follow the correction along this arc within the tolerance", "the correction bends too much, or the arc is too short for its digits", "post the arc as lines, or allow more with --tolerance-um");
      return false;
    }
    const bool first = written == 0, last = piece.s1 >= 1;
    const Vec3 start = p_out;
    extra.clear();
    command(piece.end, first, p_out, &extra);
    command_centre(piece, start, first, &extra);
    put_feed_share(piece.s1 - piece.s0, first, &extra);
    if (!last || !first) {
      if (first) stops_to_last(true, nullptr);
      if (last) stops_to_last(false, &extra);
    }
    if (first && !last && turns > 1) {
      if (const Word* p = instruction_.find(block_, 'P')) edit_.remove(*p);
    }
    if (!first) {
      tail += block_.slash ? "/" : "";
      tail += extra.substr(block_.slash ? 0 : 1);
      tail += last ? eol_ : inner_eol;
      ++report_.lines_out;
      const double length = nominal->length() * (piece.s1 - piece.s0);
      if (report_.shortest_split == 0 || length < report_.shortest_split) report_.shortest_split = length;
    }
    ++written;
    ++report_.arcs_out;
    s0 = piece.s1;
  }
  const std::size_t begin = out.size();
  edit_.append_to(out);
  const std::string_view line_eol = eol_;
  if (written > 1) eol_ = inner_eol;
  end_line(out, begin);
  eol_ = line_eol;
  out += tail;
  if (written > 1) ++report_.blocks.split;
  if (edit_.changed()) ++report_.blocks.rewritten;
  if (number_ == job_.trace_line) move_text_ = written > 1 ? fmt::format("arc in {} arcs: the correction turns it into an ellipse or tilts it", written) : "arc: stays one arc";
  out_.m = out_.frames.to_machine(p_out);
  for (int k = 0; k < 3; ++k) {
    if (withheld_ & (1u << k)) out_.m[k] = move.m1[k];
  }
  in_.m = move.m1;
  last_correction_ = withheld_ == 0 ? c1 : std::nullopt;
  start_corrected_ = withheld_ == 0;
  return true;
}

}  // namespace abbe
