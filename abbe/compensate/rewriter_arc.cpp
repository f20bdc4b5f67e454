#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/compensate/rewriter.h"
#include "abbe/compensate/turning_points.h"
#include "abbe/core/number.h"
#include "abbe/core/units.h"

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
// A radius rounded to the last digit moves the centre by R / h: beyond this chord/2R it is written as a
// centre.
constexpr double kLargestRadiusForm = 0.94;
constexpr double kUnchanged = 1e-9;  // mm
// Smaller components of a way are rounding, mm.
constexpr double kSameWay = 1e-8;
// An axis has turned round when it has moved back by this share of the tolerance.
constexpr double kTurned = 0.1;
// An arc whose radius is below this many tolerances and digits has no room to take up lost motion on its way.
constexpr double kTightArc = 25;
constexpr double kCoarsestDigit = 0.5 * um;

}  // namespace

std::optional<Arc> Rewriter::nominal_arc(const Vec3& p0, const Vec3& p1) {
  const int a = plane_axes(modal_.plane)[0], b = plane_axes(modal_.plane)[1];
  const bool clockwise = instruction_.motion == 20;
  const Word* r = instruction_.find(*block_, 'R');
  const std::array<const Word*, 3> centre_word = {
      instruction_.find(*block_, 'I'), instruction_.find(*block_, 'J'), instruction_.find(*block_, 'K')};
  const Word* wa = centre_word[static_cast<std::size_t>(a)];
  const Word* wb = centre_word[static_cast<std::size_t>(b)];
  const double unit = modal_.unit();
  const auto bad = [&](const std::string& what, const char* why, const char* fix) {
    refuse_block("E-ARC", what, why, fix);
    return std::nullopt;
  };
  for (int k = 0; k < 3; ++k) {
    if (k != a && k != b && centre_word[static_cast<std::size_t>(k)]) {
      return bad(fmt::format("{} is not in the plane of this arc", "IJK"[k]), "the control refuses it",
                 "check G17, G18, G19");
    }
  }
  int turns = 1;
  if (const Word* p = instruction_.find(*block_, 'P')) {
    if (p->value < 1 || p->value != std::floor(p->value) || p->value > 1000)
      return bad("P of an arc is a number of turns, 1 to 1000", "the path is not defined", "correct P");
    turns = static_cast<int>(p->value);
  }
  double ca = 0, cb = 0;
  if (block_->pole == Block::Pole::used) {
    if (!pole_in_)
      return bad("an arc about a pole that no CC has set since the frame changed", "the path is not defined",
                 "write CC X.. Y.. before it");
    ca = pole_in_->a;
    cb = pole_in_->b;
  } else if (r) {
    if (wa || wb) return bad("an arc with R and with I J K", "the control refuses it", "keep one form");
    const auto centre = centre_of_radius(modal_.plane, p0, p1, r->value * unit, clockwise);
    if (!centre)
      return bad(fmt::format("no arc of radius {} joins the ends", r->value), "the path is not defined",
                 "check R and the end point");
    ca = centre->a;
    cb = centre->b;
  } else {
    if (!wa && !wb)
      return bad("an arc without I J K and without R", "the path is not defined", "add the centre");
    if ((places_centre(a) || places_centre(b)) && (!wa || !wb))
      return bad("a centre that is a place (G90.1, AC) needs both centre words", "the path is not defined",
                 "add the missing one");
    ca = (wa ? wa->value * unit : 0.0) + (places_centre(a) ? 0.0 : p0[a]);
    cb = (wb ? wb->value * unit : 0.0) + (places_centre(b) ? 0.0 : p0[b]);
  }
  const auto arc = arc_about(modal_.plane, p0, p1, ca, cb, clockwise, turns);
  if (!arc) return bad("an arc of radius zero", "the path is not defined", "check the centre");
  const double difference = std::abs(arc->r1 - arc->r0);
  const Profile::Arcs& arcs = profile_.arcs;
  if (difference > arcs.limit ||
      (difference > arcs.tolerance && difference > arcs.relative * std::max(arc->r0, arc->r1))) {
    return bad(fmt::format("the radius is {:.4f} mm at the start and {:.4f} mm at the end", arc->r0, arc->r1),
               "the control refuses it", "check the centre words");
  }
  return arc;
}

// Where the end will stand once its words are rounded: as `command` will write them.
Vec3 Rewriter::rounded_end(const Vec3& want, const Vec3& p_out, bool first) const {
  Vec3 end = p_out;
  for (int k = 0; k < 3; ++k) {
    double base = 0;
    const Value value = axis_value(k, want, p_out, first, base);
    if (value.written)
      end[k] = base + rounded(value.number, decimals_of(axis_word(k))) * modal_.unit();
    else if (first && axis_word(k))
      end[k] = base + value.number * modal_.unit();
  }
  return end;
}

// The value of a centre word; a G91.1 word that is absent is zero.
Rewriter::Value Rewriter::centre_value(int k, double centre, const Vec3& start, bool first,
                                       double& base) const {
  const Word* named = instruction_.find(*block_, "IJK"[k]);
  const Word* word = first ? named : nullptr;
  if (profile_.text.conversational) {
    base = 0;
    const int decimals = decimals_of(nullptr);
    if (!pole_out_) return {rounded(centre / modal_.unit(), decimals), true};
    return value_for(centre / modal_.unit(), nullptr, (k == 0 ? pole_out_->a : pole_out_->b) / modal_.unit(),
                     decimals);
  }
  // in blocks that are added no word stands between brackets
  base = modal_.absolute_centre || (first && places_centre(k)) ? 0.0 : start[k];
  const double wanted = (centre - base) / modal_.unit();
  if (modal_.absolute_centre && !word) return {rounded(wanted, decimals_of(named)), true};
  return value_for(wanted, word, 0.0, decimals_of(named));
}

bool Rewriter::fit_piece(const Arc& nominal, double s0, double s1, const Vec3& start, bool whole,
                         ArcPiece& piece) {
  const Arc part = piece_of(nominal, s0, s1);
  const int a = plane_axes(modal_.plane)[0], b = plane_axes(modal_.plane)[1];
  const auto looks = std::clamp(
      static_cast<int>(
          std::ceil(std::max(std::abs(part.sweep) / kTurn * kLooksPerTurn, part.length() / kLookSpacing))),
      kFewestLooks, kMostLooks);
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
  // Passing through the work offset leaves rounding: the control reads ends this close as one point, a full
  // circle.
  const auto same_place = [&](const Vec3& p, const Vec3& q) {
    return std::hypot(p[a] - q[a], p[b] - q[b]) < kUnchanged;
  };
  const bool closed = same_place(nominal_start, nominal_end);
  piece.end = targets_.back().point;
  if (profile_.text.conversational) piece.end.z() = start.z();  // C and CR stay in their plane
  if (closed) {
    piece.end[a] = start[a];
    piece.end[b] = start[b];
  }
  Vec3 end = rounded_end(piece.end, start, piece.first);
  if (!closed && same_place(start, end)) {
    // The rounded end fell on the start, which would be a full circle: one last digit onwards along the
    // chord.
    const int along =
        std::abs(nominal_end[a] - nominal_start[a]) >= std::abs(nominal_end[b] - nominal_start[b]) ? a : b;
    const double digit = 2 * half_digit(decimals_of(axis_word(along))) * modal_.unit();
    piece.end[along] = start[along] + (nominal_end[along] > nominal_start[along] ? digit : -digit);
    end = rounded_end(piece.end, start, piece.first);
  }
  if (closed != same_place(start, end)) return false;
  const bool clockwise = nominal.sweep < 0;
  const int turns =
      whole ? std::max(1, static_cast<int>(std::ceil(std::abs(nominal.sweep) / kTurn - 1e-9))) : 1;
  const Word* r = instruction_.find(*block_, 'R');
  const double stretch = out_.frames.stretch();  // what a length of the program is on the machine
  const auto holds = [&](const Centre& centre) {
    const auto arc = arc_about(modal_.plane, start, end, centre.a, centre.b, clockwise, turns);
    if (!arc || std::abs(arc->sweep - part.sweep) > kSweepSlack) return false;
    const double mismatch = std::abs(arc->r1 - arc->r0), spiral = std::abs(part.r1 - part.r0);
    if (std::max(1.0, stretch) * mismatch > stretch * spiral + profile_.arcs.tolerance / 2) return false;
    return stretch * distance_to(*arc, targets_) <= interpolation_ + stretch * digit_room();
  };
  piece.keeps_radius = false;
  if (r && whole) {
    const double chord = std::hypot(end[a] - start[a], end[b] - start[b]);
    const auto centre = centre_of_radius(modal_.plane, start, end, r->value * modal_.unit(), clockwise);
    // Ends that did not change mean what they meant, however badly R says it.
    const bool unchanged =
        (start - nominal_start).norm() < kUnchanged && (end - nominal_end).norm() < kUnchanged;
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
    const Value value = centre_value(k, centre, start, piece.first, base);
    const int decimals = decimals_of(instruction_.find(*block_, "IJK"[k]));
    return base + (value.written ? rounded(value.number, decimals) : value.number) * modal_.unit();
  };
  piece.centre = {as_written(a, fitted.a), as_written(b, fitted.b)};
  return holds(piece.centre);
}

// What a piece of an arc does in the plane, as its words say it.
std::optional<PlaneWay> Rewriter::written_way(const ArcPiece& piece, const Vec3& start,
                                              const Vec3& end) const {
  const bool clockwise = instruction_.motion == 20;
  if (!piece.keeps_radius) return arc_way(start, end, piece.centre, clockwise);
  const double radius = instruction_.find(*block_, 'R')->value * modal_.unit();
  const auto centre = centre_of_radius(Plane::xy, start, end, radius, clockwise);
  return centre ? arc_way(start, end, *centre, clockwise) : std::nullopt;
}

void Rewriter::command_centre(const ArcPiece& piece, const Vec3& start, bool first, std::string* extra) {
  const int a = plane_axes(modal_.plane)[0], b = plane_axes(modal_.plane)[1];
  if (piece.keeps_radius) return;
  if (const Word* r = instruction_.find(*block_, 'R'); r && first) edit_.remove(*r);
  for (const int k : {a, b}) {
    double base = 0;
    const Word* named = instruction_.find(*block_, "IJK"[k]);
    const Value value = centre_value(k, k == a ? piece.centre.a : piece.centre.b, start, first, base);
    if (value.written) put("IJK"[k], first ? named : nullptr, value.number, decimals_of(named), first, extra);
  }
  // Both words zero would leave the block without a centre.
  if (!modal_.absolute_centre && !first && extra->find_first_of("IJK") == std::string::npos)
    *extra += fmt::format(" {}0.0", "IJK"[a]);
}

double Rewriter::shortest_take_up() const { return job_.tolerance + kCoarsestDigit; }

void Rewriter::follow(const Vec3& way, unsigned known) {
  if (!job_.reversal) return;
  for (int k = 0; k < 3; ++k) {
    if (!(known & (1u << k)) || std::abs(way[k]) <= kSameWay) continue;
    approach_[static_cast<std::size_t>(k)] = way[k] > 0 ? 1 : -1;
  }
}

// Cuts an arc where an axis turns round and its lost motion shows. Ends with the last direction in approach_.
bool Rewriter::read_stretches(const Arc& nominal) {
  stretches_.assign(1, {0, 1, approach_});
  if (!job_.reversal || !field_.depends_on_direction()) return true;
  const Vec3 x = in_.frames.vector_to_machine(Vec3::UnitX());
  auto ends = turning_points(nominal, std::atan2(x.y(), x.x()), kTurned * job_.tolerance);
  ends.push_back(1);
  double s0 = 0;
  for (const double s1 : ends) {
    follow(in_.frames.vector_to_machine(nominal.direction((s0 + s1) / 2)), 7);
    Stretch& last = stretches_.back();
    if (s0 == 0) {
      last = {0, s1, approach_};
    } else {
      double jump = 0;
      for (const double s : {s0, (s0 + s1) / 2, s1}) {
        const Vec3 at = in_.frames.to_machine(nominal.at(s));
        const auto before = correction_at(at, withheld_, last.approach),
                   after = correction_at(at, withheld_, approach_);
        if (!before || !after) return false;
        jump = std::max(jump, (*after - *before).norm());
      }
      if (jump > interpolation_ / 2) {
        stretches_.push_back({s0, s1, approach_});
      } else {
        last.s1 = s1;
      }
    }
    s0 = s1;
  }
  return true;
}

// Where the output must go before the arc goes on at s: the place there with the direction of what follows.
std::optional<Vec3> Rewriter::place_to_take_up(const Arc& nominal, double s, const Vec3& p_out) {
  if (!job_.reversal || !field_.depends_on_direction() || nominal.length() <= shortest_take_up())
    return std::nullopt;
  if (s == 0 && !start_corrected_) return std::nullopt;
  const Vec3 m = in_.frames.to_machine(nominal.at(s));
  const auto c = correction_at(m, withheld_, approach_);
  if (!c || (m + *c - out_.frames.to_machine(p_out)).norm() <= interpolation_) return std::nullopt;
  if (modal_.feed_mode == 930) {
    refuse_block("E-REVERSAL", "lost motion must be taken up in an inverse-time (G93) block",
                 "the extra block would need a time of its own", "post with G94");
    return std::nullopt;
  }
  return out_.frames.to_program(m + *c);
}

void Rewriter::take_up_on_arc(const Vec3& want, bool first, Vec3& p_out, std::string* extra) {
  if (!first) {
    *extra += " G1";
    return command(want, false, p_out, extra);
  }
  constexpr int kAxes = 3;  // the bits above are those of I J K
  if (block_->places >> kAxes != 0)
    refuse_block("E-REVERSAL", "lost motion must be taken up before an arc whose centre is in brackets (AC)",
                 "its first block becomes a line", "post the centre with I and J");
  const Word* code = nullptr;
  for (int i = 0; i < block_->count; ++i) {
    const Word& word = block_->words[static_cast<std::size_t>(i)];
    if (word.letter == 'G' && (word.value == 2 || word.value == 3)) code = &word;
    if (std::string_view("IJKRP").find(word.letter) != std::string_view::npos) edit_.remove(word);
  }
  if (code) {
    edit_.replace(*code) = "1";
  } else {
    edit_.add('G') += "1";
  }
  command(want, true, p_out, nullptr);
}

bool Rewriter::holds_withheld(const Vec3& m, const char* what) {
  if (withheld_ == 0) return true;
  const auto full = correction_at(m, 0, approach_);
  if (!full) return false;
  for (int k = 0; k < 3; ++k) {
    if (!(withheld_ & (1u << k)) || std::abs((*full)[k]) <= job_.tolerance) continue;
    refuse_block("E-POS",
                 fmt::format("{} while {} stands where G53 put it, without its correction", what, "XYZ"[k]),
                 "a word is not added to an axis that the program commanded in machine coordinates",
                 "command the axis in the work offset first");
    return false;
  }
  return true;
}

bool Rewriter::arc(const Move& move, std::string& out) {
  if (!feed_allowed(move)) return false;  // knows its start, and so its end
  if (in_.frames.rotated() && (modal_.plane != Plane::xy || (withheld_ & 3u))) {
    refuse_block("E-ROTATION", "an arc out of the XY plane in a rotated work offset",
                 "it is not an arc of the machine's axes", "set the offset without rotation");
    return false;
  }
  if (!in_.frames.stretches_evenly()) {
    refuse_block("E-FRAME", "an arc while the axes are scaled by different factors",
                 "it is no arc of the machine's axes", "post the arc as lines, or scale in the CAM system");
    return false;
  }
  const auto nominal = nominal_arc(in_.frames.to_program(move.m0), in_.frames.to_program(move.m1));
  if (!nominal) return false;
  ++report_.arcs_in;
  if (!read_stretches(*nominal)) return false;
  if (approach_ != stands_) last_correction_.reset();  // it was for the other direction
  const auto last_approach = approach_;
  if (!holds_withheld(move.m1, "an arc")) return false;
  const auto c1 = correction_at(move.m1, withheld_, stretches_.back().approach);
  if (!c1) return false;
  note_correction(move.m1, *c1);

  if (cutter_.acts() && !arc_beside(*nominal)) return false;
  Vec3 p_out = out_.p();
  const bool written = write_arc(*nominal, out, p_out);
  approach_ = last_approach;
  if (!written) return false;
  out_.m = out_.frames.to_machine(p_out);
  for (int k = 0; k < 3; ++k) {
    if (withheld_ & (1u << k)) out_.m[k] = move.m1[k];
  }
  in_.m = move.m1;
  last_correction_ = withheld_ == 0 ? c1 : std::nullopt;
  start_corrected_ = withheld_ == 0;
  stands_ = stretches_.back().approach;
  return true;
}

// As few equal pieces of what is left as hold; several turns are either one block or unrolled. Pieces that
// would be too short in time are not made: then what is left of the tolerance is spent, too.
bool Rewriter::fit_part(const Arc& nominal, double s0, double end, const Vec3& start, ArcPiece& piece) {
  const double usual = interpolation_;
  for (const double tolerance : {usual, job_.tolerance}) {
    interpolation_ = tolerance;
    bool fitted = false;
    for (int k = 1; k <= kMostPieces && !fitted && !findings_.refused(); k = k < 8 ? k + 1 : k + k / 4) {
      const double s1 = k == 1 ? end : s0 + (end - s0) / k;
      const bool whole = piece.first && s0 == 0 && s1 == 1;
      if (!whole && std::abs(nominal.sweep) * (s1 - s0) > kTurn * 0.98) continue;
      if (k > 1 && s1 - s0 < splitting_.least) break;
      if (!whole && cutter_.acts() && nominal.length() * (s1 - s0) < shortest_end()) break;
      fitted = fit_piece(nominal, s0, s1, start, whole, piece);
    }
    interpolation_ = usual;
    if (fitted && tolerance > usual) hold_splits(tolerance);
    if (fitted || splitting_.least == 0) return fitted;
  }
  return false;
}

bool Rewriter::write_arc(const Arc& nominal, std::string& out, Vec3& p_out) {
  measure_split(nominal.length() * in_.frames.stretch());  // F is of the way on the machine
  const bool by_pole = profile_.text.conversational;
  if (by_pole) {
    const auto leaves = leaves_plane(nominal, p_out.z());
    if (!leaves) return false;
    // beside a contour chords would be corners: there the arc stays, if it is good enough
    if (*leaves && stretches_.size() == 1 && !cutter_.acts()) return chords(nominal, out, p_out);
  }
  std::string lead;  // blocks in front of the first
  std::string extra, tail;
  int blocks = 0, pieces = 0;
  const int turns = std::max(1, static_cast<int>(std::ceil(std::abs(nominal.sweep) / kTurn - 1e-9)));
  const std::string_view inner_eol = file_eol_.empty() ? std::string_view("\n") : std::string_view(file_eol_);
  const auto end_block = [&](bool last) {
    if (blocks++ == 0) return;
    add_block(extra, last ? eol_ : inner_eol, tail);
  };
  for (const Stretch& stretch : stretches_) {
    approach_ = stretch.approach;
    const auto place = place_to_take_up(nominal, stretch.s0, p_out);
    bool straight = place.has_value();
    if ((place || stretch.s0 > 0) && std::min(nominal.r0, nominal.r1) < kTightArc * shortest_take_up()) {
      refuse_block("E-REVERSAL", "an axis turns round on an arc that is too small to take up its lost motion",
                   "nothing can be put between its parts",
                   "leave the arc out, or leave --reversal away: the mean is compensated and the lost motion "
                   "reported");
      return false;
    }
    if (place && profile_.text.conversational) {
      refuse_block("E-REVERSAL", "lost motion must be taken up on an arc",
                   "a line in front of the arc would take its feed and its codes",
                   "post arcs as lines, or leave --reversal away");
      return false;
    }
    if (place) {
      extra.clear();
      if (blocks == 0) stops_to_last(true, nullptr);
      take_up_on_arc(*place, blocks == 0, p_out, &extra);
      end_block(false);
    }
    double s0 = stretch.s0;
    while (s0 < stretch.s1) {
      ArcPiece piece;
      piece.first = blocks == 0;
      if (!fit_part(nominal, s0, stretch.s1, p_out, piece)) {
        if (findings_.refused()) return false;
        if (splitting_.least > 0) return refuse_short_blocks(job_.tolerance);
        if (!start_corrected_ && s0 == 0) {
          refuse_block("E-POS",
                       "an arc that begins where an axis is not corrected, and bends towards its end",
                       "no arc leads from there onto the path within the tolerance: G53, a home position or "
                       "another frame has left the axis where it is",
                       "go to the arc's start with a G0 or G1 that names X, Y and Z");
          return false;
        }
        refuse_block("E-TOL", "no arcs follow the correction along this arc within the tolerance",
                     "the correction bends too much, or the arc is too short for its digits",
                     "post the arc as lines, or allow more with --tolerance-um");
        return false;
      }
      const bool first = piece.first, last = piece.s1 >= 1;
      const Vec3 start = p_out;
      extra.clear();
      if (straight) extra = instruction_.motion == 20 ? " G2" : " G3";
      straight = false;
      if (by_pole) begin_pole_arc(piece, first ? lead : tail, extra);
      command(piece.end, first, p_out, &extra);
      if (cutter_.acts() && !follow_offset(written_way(piece, start, p_out), nominal.direction(s0)))
        return false;
      if (by_pole) {
        end_pole_arc(first, extra);
      } else {
        command_centre(piece, start, first, &extra);
      }
      put_feed_share(piece.s1 - piece.s0, first, &extra);
      if (first && !last) {
        stops_to_last(true, nullptr);
        if (const Word* p = instruction_.find(*block_, 'P'); p && turns > 1) edit_.remove(*p);
      }
      if (last && !first) stops_to_last(false, &extra);
      if (piece.s1 - piece.s0 < 1) note_piece(piece.s1 - piece.s0);
      end_block(last);
      ++pieces;
      ++report_.arcs_out;
      s0 = piece.s1;
    }
  }
  out += lead;
  const std::size_t begin = out.size();
  edit_.append_to(out);
  const std::string_view line_eol = eol_;
  if (blocks > 1) eol_ = inner_eol;
  end_line(out, begin);
  eol_ = line_eol;
  out += tail;
  if (blocks > 1) ++report_.blocks.split;
  if (edit_.changed()) ++report_.blocks.rewritten;
  if (number_ != job_.trace_line) return true;
  if (blocks > pieces) {
    move_text_ = fmt::format("arc in {} arcs; {} short moves take up lost motion where an axis turns round",
                             pieces, blocks - pieces);
  } else {
    move_text_ =
        pieces > 1
            ? fmt::format("arc in {} arcs: the correction turns it into an ellipse or tilts it", pieces)
            : "arc: stays one arc";
  }
  return true;
}

}  // namespace abbe
