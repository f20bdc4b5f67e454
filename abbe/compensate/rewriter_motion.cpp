#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"

namespace abbe {
namespace {

// Long moves are looked at least this often, mm.
constexpr double kSampleSpacing = 10;
// Between places closer than this no further one is looked at, mm.
constexpr double kFineSpacing = 2;
constexpr std::size_t kMaxUniform = 64;
// A command may leave its range by the rounding of its digits.
constexpr double kTravelSlack = 1e-6;

}  // namespace

// Where the original goes: words are program coordinates (G53: machine coordinates), G91 from where it
// stands.
bool Rewriter::read_move(Move& move) {
  move.m0 = move.m1 = in_.m;
  move.known0 = move.known1 = known_;
  for (int k = 0; k < 3; ++k) move.named |= axis_word(k) ? 1u << k : 0u;
  if (!read_turns(move)) return false;
  if (instruction_.zero == 530) {
    if (modal_.incremental) {
      refuse_block("E-G53", "G53 in G91", "controls differ on what incremental machine coordinates mean",
                   "write G90 before");
      return false;
    }
    if (profile_.tools.in_machine_coordinates && in_.frames.tool_offset() != Vec3::Zero()) {
      refuse_block("E-G53", "machine coordinates while a tool offset is in force",
                   "on this control the tip goes there, not the axes", "write D0 in the block");
      return false;
    }
    for (int k = 0; k < 3; ++k) {
      if (const Word* word = axis_word(k)) move.m1[k] = word->value * modal_.unit();
    }
    if (tcp_ && move.named != 0) {
      refuse_block("E-TCP", "machine coordinates (G53) while tool centre point control is on",
                   "controls differ on what they mean then", "switch tool centre point control off before");
      return false;
    }
    move.known1 |= move.named;
    if (!profile_.offsets.increments_sure) shifted_ |= move.named;
    return true;
  }
  const Frames& frames = in_.frames;
  if (!frames.known()) {
    const auto active = static_cast<std::size_t>(frames.active());
    if (!frame_reported_[active]) {
      frame_reported_[active] = true;
      const std::string label = work_offset_label(frames.active());
      std::string option = label;
      std::erase(option, ' ');  // "G54.1P4"
      const std::string fix = fmt::format(
          "give it: --offset {}=X..,Y..,Z.. (to about 1 mm), or the control's parameter file with --var",
          option);
      refuse_block("E-WCS", fmt::format("the work offset {} is not known", label),
                   "where on the machine the program runs, and so how large the errors are, depends on it",
                   fix.c_str());
    }
    return false;
  }
  const unsigned distances = increments();
  if ((distances & move.named & shifted_) != 0 || (modal_.incremental && (move.named & shifted_) != 0)) {
    refuse_block("E-POS", "an increment of an axis whose zero has moved since it was commanded",
                 "the control adds that shift to it, or does not, as a setting says",
                 "command the axis to a place first: in G90, or without I");
    return false;
  }
  if (!modal_.incremental) shifted_ &= ~(move.named & ~distances);
  // Coordinates stay in registers: stored one by one and loaded together they would have to be waited for.
  const Vec3 p0 = frames.to_program(in_.m);
  const auto coordinate = [&](int k) {
    const Word* word = axis_word(k);
    return word ? word->value * modal_.unit() + ((distances & 1u << k) != 0 ? p0[k] : 0.0) : p0[k];
  };
  const Vec3 m1 = frames.to_machine(Vec3(coordinate(0), coordinate(1), coordinate(2)));
  move.known1 |= move.named & 7u & ~distances;
  // A rotated frame mixes X and Y: one is known only with the other.
  if (frames.rotated() && (move.known1 & 3u) != 3u) move.known1 &= ~3u;
  // Axes that are not named stay exactly where they are.
  const unsigned moved = frames.tilted() ? 7u : frames.rotated() ? move.named | 3u : move.named;
  move.m1 = moved == 7 ? m1
                       : Vec3((moved & 1u) ? m1.x() : in_.m.x(), (moved & 2u) ? m1.y() : in_.m.y(),
                              (moved & 4u) ? m1.z() : in_.m.z());
  return true;
}

// Machine coordinates are copied, so they are the program's own if they leave a travel.
bool Rewriter::check_travel(const Move& move) {
  for (int k = 0; k < 6; ++k) {
    const auto i = static_cast<std::size_t>(k % 3);
    if ((move.named & (1u << k)) == 0) continue;
    const int axis = k < 3 ? axes_.linear[i] : axes_.rotary[i];
    const double at = k < 3 ? move.m1[k] : move.turns1[i], unit = k < 3 ? 1 : deg;
    const auto& range = machine_.axis(axis).range;
    if (!range || (at >= (*range)[0] - kTravelSlack && at <= (*range)[1] + kTravelSlack)) continue;
    report_.out_of_volume = true;
    refuse_block("E-TRAVEL",
                 fmt::format("{} {:.4f} {}: outside the travel of the axis", "XYZABC"[k], at / unit,
                             k < 3 ? "mm" : "deg"),
                 "the control would stop there, or the machine file's range is wrong",
                 "check the block and `range` in the machine file");
    return false;
  }
  return true;
}

void Rewriter::motion(std::string& out) {
  if (is_cycle(instruction_.motion)) return cycle(out);
  if (instruction_.motion == kNurbs) {
    refresh_datum();
    return spline(out);
  }
  Move move;
  if (!stand_on_plane() || !read_move(move) || !plane_allows(move)) return;
  refresh_datum();
  const bool machine_frame = instruction_.zero == 530;
  if (!machine_frame) keep_turns(move);
  if (cutter_.acts() && !cutter_allows(move)) {
    out_.m = move.m1;
  } else if (machine_frame) {
    withheld_ |= move.named & 7u;
    for (std::size_t k = 0; k < 3; ++k) {
      if (move.named & (8u << k)) out_.turns[k] = move.turns1[k];
    }
    for (int k = 0; k < 3; ++k) {
      if (move.named & (1u << k)) out_.m[k] = move.m1[k];
    }
    follow(move.m1 - move.m0, move.known0);
    if (instruction_.motion == 10 && (move.known0 & move.named) != move.named) {
      refuse_block("E-POS", "a feed move from an unknown position", "the path cannot be followed",
                   "begin with G0, or give the position with --start");
      return;
    }
    if (!check_travel(move)) return;
    ++report_.blocks.passed;
    move_text_ =
        "G53: machine coordinates are copied; these axes are corrected again when the program commands them";
    pass(out);
  } else if (is_arc(instruction_.motion)) {
    withheld_ &= ~move.named;
    if (modal_.vectors) {
      refuse_block("E-VECTOR", "an arc while I J K are the tool's direction",
                   "whether they are its centre then is not sure", "post arcs with G43.4, or as lines");
      return;
    }
    if (move.turns()) {
      refuse_block("E-ROTARY", "a rotary axis turns along an arc",
                   "how the control joins both motions is not known", "post such paths as lines");
      out_.turns = move.turns1;
    } else if (arc(move, out)) {
      return;
    }
    out_.m = move.m1;
  } else if (move.known1 != needed_) {
    uncorrected(move, out);
  } else {
    withheld_ &= ~move.named;
    if (move.turns() ? turn(move, out) : straight(move, out)) return;
    out_.m =
        move.m1;  // refused: nothing is written any more, but what follows is judged from where it starts
    out_.turns = move.turns1;
  }
  in_.m = move.m1;
  in_.turns = move.turns1;
  stand(in_.turns, out_.turns);
  known_ = move.known1;
  last_correction_.reset();
  last_way_.reset();
  start_corrected_ = false;
}

void Rewriter::uncorrected(const Move& move, std::string& out) {
  if (instruction_.motion != 0) {
    refuse_block("E-POS", "a feed move while the position of an axis is not known",
                 "the correction depends on all axes",
                 "begin with rapid moves that name X, Y and Z, or give the machine's position with --start "
                 "X..,Y..,Z.. (after M6: --tool-change keeps, if it does not move)");
  }
  // The words stand as they are; only they say where the output goes.
  Vec3 p = out_.p();
  for (int k = 0; k < 3; ++k) {
    if (const Word* word = axis_word(k))
      p[k] = word->value * modal_.unit() + ((increments() & 1u << k) != 0 ? p[k] : 0.0);
  }
  const Vec3 m = out_.frames.to_machine(p);
  for (int k = 0; k < 3; ++k) {
    if ((move.named & (1u << k)) || (out_.frames.rotated() && k < 2) || out_.frames.tilted())
      out_.m[k] = m[k];
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (move.named & (8u << k))
      out_.turns[k] = modal_.incremental ? out_.turns[k] + move.turns1[k] - move.turns0[k] : move.turns1[k];
  }
  ++report_.blocks.passed;
  move_text_ = "the position of an axis is not known yet: the rapid is copied";
  pass(out);
}

bool Rewriter::feed_allowed(const Move& move) {
  if (move.known0 != needed_) {
    refuse_block("E-POS", "a feed move from a position that is not known",
                 "the path, and so its correction, cannot be followed",
                 "begin with rapid moves that name X, Y and Z, or give the machine's position with --start "
                 "X..,Y..,Z.. (after M6: --tool-change keeps, if it does not move)");
    return false;
  }
  if (modal_.feed_mode == 930 && !instruction_.find(*block_, 'F')) {
    refuse_block("E-FEED", "inverse time (G93) without F in the block", "the control refuses it",
                 "add F to the block");
    return false;
  }
  return feed_above_zero();
}

bool Rewriter::feed_above_zero() {
  if (modal_.feed_mode == 930 || !modal_.has_feed || modal_.feed > 0) return true;
  refuse_block("E-FEED", "a feed motion with F0", "the control stops with an alarm", "state a feed above 0");
  return false;
}

void Rewriter::note_correction(const Vec3& m, const Vec3& c) {
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (std::abs(c[k]) <= report_.max_correction[i]) continue;
    report_.max_correction[i] = std::abs(c[k]);
    report_.max_line[i] = number_;
    extremes_[i] = {m, in_.frames.datum_point(), gauge_, true};
  }
  if (!(c.squaredNorm() <= job_.max_correction * job_.max_correction)) {
    refuse_block("E-CORRECTION",
                 fmt::format("the correction is {:.1f} um, {:.0f} um is the limit", c.norm() / um,
                             job_.max_correction / um),
                 "so large a correction is usually a wrong unit, sign or offset",
                 "check the machine file; --max-correction-um raises the limit");
  }
  if (last_correction_) {
    const double way = (m - in_.m).squaredNorm(), change = (c - *last_correction_).squaredNorm();
    const double known = std::min(report_.max_gradient, job_.max_gradient);
    if (way > kGradientBase * kGradientBase && change > known * known * way) {
      const double gradient = std::sqrt(change / way);
      report_.max_gradient = std::max(report_.max_gradient, gradient);
      extremes_[3] = {m, in_.frames.datum_point(), gauge_, true};
      if (gradient > job_.max_gradient) {
        refuse_block("E-GRADIENT",
                     fmt::format("the correction changes by {:.2f} mm per m, {:.2f} is the limit",
                                 gradient * 1e3, job_.max_gradient * 1e3),
                     "no machine is that crooked: a table has a step, or a unit is wrong",
                     "check the error tables of the machine file");
      }
    }
  }
}

std::optional<Vec3> Rewriter::correction_at(const Vec3& m, unsigned withheld,
                                            const std::array<signed char, 3>& approach) {
  const auto answer = field_.at(m, withheld, approach);
  using Trouble = CorrectionField::Trouble;
  switch (answer.trouble) {
    case Trouble::none:
      return Vec3(answer.q - m);
    case Trouble::travel:
      report_.out_of_volume = true;
      refuse_block("E-TRAVEL",
                   fmt::format("{} {:.4f} {}: outside the travel of the axis", "XYZABC"[answer.axis],
                               answer.axis < 3 ? answer.at : answer.at / deg, answer.axis < 3 ? "mm" : "deg"),
                   "the control would stop there, or the machine file's range is wrong",
                   "check the work offset (--offset) and `range` in the machine file");
      return std::nullopt;
    case Trouble::outside:
      report_.out_of_volume = true;
      refuse_block(
          "E-VOL",
          fmt::format("X {:.3f} Y {:.3f} Z {:.3f} mm: outside the calibrated volume", m.x(), m.y(), m.z()),
          "beyond the measured range the errors are not known",
          "check the work offset (--offset) and the temperatures, or measure a larger volume");
      return std::nullopt;
    case Trouble::failed:
      break;
  }
  refuse_block("E-SOLVE",
               fmt::format("no correction was found at X {:.3f} Y {:.3f} Z {:.3f} mm", m.x(), m.y(), m.z()),
               "the errors of the machine file are too large or not finite there",
               "check the machine file with `abbe predict`");
  return std::nullopt;
}

// Looks along a move: where tables have their nodes, and evenly.
bool Rewriter::sample_line(const Move& move, const Vec3& end_correction,
                           const std::array<signed char, 3>& approach) {
  samples_.clear();
  const Vec3 way = move.m1 - move.m0;
  const double length = way.norm();
  samples_.push_back({0, Vec3::Zero()});
  const auto uniform =
      std::clamp(static_cast<std::size_t>(std::ceil(length / kSampleSpacing)), std::size_t{2}, kMaxUniform);
  for (std::size_t i = 1; i < uniform; ++i)
    samples_.push_back({static_cast<double>(i) / static_cast<double>(uniform), Vec3::Zero()});
  for (int k = 0; k < 3; ++k) {
    if (std::abs(way[k]) < kFineSpacing / 10) continue;
    const auto& knots = field_.knots(k);
    const double lo = std::min(move.m0[k], move.m1[k]), hi = std::max(move.m0[k], move.m1[k]);
    for (auto it = std::upper_bound(knots.begin(), knots.end(), lo); it != knots.end() && *it < hi; ++it) {
      samples_.push_back({(*it - move.m0[k]) / way[k], Vec3::Zero()});
    }
  }
  samples_.push_back({1, end_correction});
  std::sort(samples_.begin(), samples_.end(),
            [](const MoveSample& a, const MoveSample& b) { return a.s < b.s; });
  // between two places the function is close to quadratic: its middle is where the chord is farthest
  const std::size_t places = samples_.size();
  for (std::size_t i = 0; i + 1 < places; ++i) {
    if ((samples_[i + 1].s - samples_[i].s) * length > kFineSpacing)
      samples_.push_back({(samples_[i].s + samples_[i + 1].s) / 2, Vec3::Zero()});
  }
  std::sort(samples_.begin(), samples_.end(),
            [](const MoveSample& a, const MoveSample& b) { return a.s < b.s; });
  for (auto& sample : samples_) {
    if (sample.s >= 1) {
      sample.correction = end_correction;
      continue;
    }
    const auto c = correction_at(move.m0 + sample.s * way, withheld_, approach);
    if (!c) return false;
    sample.correction = *c;
  }
  return true;
}

void Rewriter::put_feed_share(double fraction, bool first, std::string* extra) {
  const Word* f = instruction_.find(*block_, 'F');
  if (timed_feed_ > 0) {
    put('F', first ? f : nullptr, timed_feed_ / fraction, 4, first, extra);
    return;
  }
  if (modal_.feed_mode != 930 || !f || fraction >= 1) return;
  if (!first) *extra += " F";
  append_fixed(first ? edit_.replace(*f) : *extra, f->value / fraction, std::max<int>(f->decimals, 4));
}

// Codes that act when the motion is done stand on the last piece of a split block.
void Rewriter::stops_to_last(bool first, std::string* extra) {
  if (!instruction_.after) return;
  for (int i = 0; i < block_->count; ++i) {
    const Word& word = block_->words[static_cast<std::size_t>(i)];
    if (!acts_after_motion(profile_, word)) continue;
    if (first) {
      edit_.remove(word);
    } else {
      *extra += ' ';
      *extra += block_->text.substr(word.begin, static_cast<std::size_t>(word.end - word.begin));
    }
  }
}

Rewriter::Value Rewriter::value_for(double wanted, const Word* word, double present, int decimals) const {
  const double stands = word ? word->value : present;
  if (std::abs(wanted - stands) <= half_digit(decimals)) return {stands, false};
  return {wanted, true};
}

Rewriter::Value Rewriter::axis_value(int k, const Vec3& want, const Vec3& p_out, bool first,
                                     double& base) const {
  const Word* named = axis_word(k);
  const Word* word = first ? named : nullptr;
  // a word that we add says a place, unless all words are distances
  const bool distance = modal_.incremental || (word != nullptr && (block_->increments & 1u << k) != 0);
  base = distance ? p_out[k] : 0.0;
  const double present = distance ? 0.0 : p_out[k] / modal_.unit();
  // An axis that G53 commanded gets no word of ours.
  if (!word && ((withheld_ | still_) & (1u << k))) return {present, false};
  return value_for((want[k] - base) / modal_.unit(), word, present, decimals_of(named));
}

double Rewriter::put(char letter, const Word* word, double number, int decimals, bool first,
                     std::string* extra) {
  if (!word && !first) {
    *extra += ' ';
    *extra += letter;
  }
  if (word) return edit_.replace(*word, number, decimals);
  return append_number(first ? edit_.add(letter) : *extra, number, decimals, block_->style);
}

void Rewriter::command(const Vec3& want, bool first, Vec3& p_out, std::string* extra, unsigned skip) {
  for (int k = 0; k < 3; ++k) {
    if (skip & (1u << k)) continue;
    double base = 0;
    const Word* named = axis_word(k);
    const Word* word = first ? named : nullptr;
    Value value = axis_value(k, want, p_out, first, base);
    if (value.written && named == nullptr && modal_.incremental && (shifted_ >> k & 1) != 0) {
      if (std::abs(value.number) < 3 * half_digit(decimals_of(named))) continue;  // of rounding
      refuse_block("E-POS",
                   fmt::format("the correction asks for an increment of {}, whose zero has moved", "XYZ"[k]),
                   "the control adds that shift to it, or does not, as a setting says",
                   "command the axis to a place first: in G90, or without I");
      return;
    }
    if (value.written) value.number = put("XYZ"[k], word, value.number, decimals_of(named), first, extra);
    if (value.written || word) p_out[k] = base + value.number * modal_.unit();
  }
}

// The first piece edits the block, the others add blocks behind it.
void Rewriter::write_pieces(const Move& move, const std::vector<Piece>& pieces, std::string& out) {
  Vec3 p_out = out_.p();
  const std::string_view inner_eol = file_eol_.empty() ? std::string_view("\n") : std::string_view(file_eol_);
  std::string extra, tail;
  for (std::size_t j = 0; j < pieces.size(); ++j) {
    const Piece& piece = pieces[j];
    const bool first = j == 0, last = j + 1 == pieces.size();
    // every block of a conversational program says what it does
    extra = profile_.text.conversational ? " L" : "";
    const std::size_t bare = extra.size();
    const Vec3 from = p_out;
    command(still_ == 0 ? piece.want : Vec3(from.x(), from.y(), piece.want.z()), first, p_out, &extra);
    if (cutter_.acts() &&
        !follow_offset(straight_way(from, p_out), out_.frames.vector_to_program(move.m1 - move.m0)))
      return;
    if (move.turns()) command_turns(move, piece, first, &extra);
    if (timed_feed_ > 0 || modal_.feed_mode == 930) put_feed_share(piece.s1 - piece.s0, first, &extra);
    if (!last && first && timed_feed_ == 0) stops_to_last(true, nullptr);
    if (!first && last && timed_feed_ == 0) stops_to_last(false, &extra);
    if (pieces.size() > 1) note_piece(piece.s1 - piece.s0);
    if (first || extra.size() == bare) continue;  // empty: the rounded end is where the last piece went
    add_block(extra, last ? eol_ : inner_eol, tail);
  }
  const std::size_t begin = out.size();
  edit_.append_to(out);
  const std::string_view line_eol = eol_;
  if (!tail.empty()) eol_ = inner_eol;
  end_line(out, begin);
  eol_ = line_eol;
  out += tail;
  if (pieces.size() > 1) ++report_.blocks.split;
  if (edit_.changed()) ++report_.blocks.rewritten;
  out_.m = out_.frames.to_machine(p_out);
  for (int k = 0; k < 3; ++k) {
    if (withheld_ & (1u << k)) out_.m[k] = move.m1[k];
  }
}

bool Rewriter::straight(const Move& move, std::string& out) {
  const bool feed = instruction_.motion == 10;
  if (feed && !feed_allowed(move)) return false;
  const Vec3 way = move.m1 - move.m0;
  follow(way, move.known0);
  const std::array<signed char, 3> approach = approach_;
  const bool turned = approach != stands_ && field_.depends_on_direction();
  if (turned) last_correction_.reset();  // it was for the other direction
  if (out_.frames.rotated() && (withheld_ & 3u)) {
    refuse_block("E-ROTATION", "X or Y stands in machine coordinates in a rotated work offset",
                 "its correction cannot be withheld there", "command X and Y after G53");
    return false;
  }
  auto c1 = correction_at(move.m1, withheld_, approach);
  if (!c1) return false;
  if (feed && withheld_ != 0) {
    const auto full = correction_at(move.m1, 0, approach);
    if (!full) return false;
    for (int k = 0; k < 3; ++k) {
      if (!(withheld_ & (1u << k)) || std::abs((*full)[k]) <= job_.tolerance) continue;
      refuse_block(
          "E-POS",
          fmt::format("a feed move while {} stands where G53 put it, without its correction of {:.1f} um",
                      "XYZ"[k], (*full)[k] / um),
          "a word is not added to an axis that the program commanded in machine coordinates",
          "command the axis in the work offset first");
      return false;
    }
  }
  note_correction(move.m1, *c1);
  if (drills_ && !feed && !lead_to_hole(move.m1, *c1)) return false;

  // Pieces of a feed move between which the correction goes straight.
  std::vector<std::size_t> ends;
  bool takes_up = false;
  if (feed) {
    const bool look = way.squaredNorm() > short_enough_ * short_enough_ || turned;
    if (look) {
      if (!sample_line(move, *c1, approach)) return false;
      takes_up = turned && start_corrected_ && way.norm() > shortest_take_up() &&
                 (move.m0 + samples_.front().correction - out_.m).norm() > interpolation_;
      if (takes_up && modal_.feed_mode == 930) {
        refuse_block("E-REVERSAL", "lost motion must be taken up in an inverse-time (G93) block",
                     "the extra block would need a time of its own", "post with G94");
        return false;
      }
      ends = split_move(samples_, interpolation_);
      measure_split(way.norm());
      if (!keep_block_time(ends)) return false;
    }
  }
  if (cutter_.acts() && feed && !keep_ends_whole(move, ends)) return false;
  pieces_.clear();
  const auto add = [&](double s1, const Vec3& m) {
    pieces_.push_back({pieces_.empty() ? 0 : pieces_.back().s1, s1, out_.frames.to_program(m), {}, {}});
  };
  if (takes_up) add(0, move.m0 + samples_.front().correction);
  for (std::size_t j = 0; j + 1 < ends.size(); ++j)
    add(samples_[ends[j]].s, move.m0 + samples_[ends[j]].s * way + samples_[ends[j]].correction);
  add(1, move.m1 + *c1);
  write_pieces(move, pieces_, out);
  if (cutter_.acts() && !cutter_moved(move.m1 + *c1)) return false;
  if (number_ == job_.trace_line) {
    move_text_ = pieces_.size() > 1
                     ? fmt::format("feed move in {} pieces: the correction bends along it", pieces_.size())
                     : (feed ? "feed move: one piece is straight enough" : "rapid: its end is corrected");
  }
  in_.m = move.m1;
  known_ = move.known1;
  last_correction_ = withheld_ == 0 ? c1 : std::nullopt;
  start_corrected_ = withheld_ == 0;
  stands_ = approach;
  return true;
}

}  // namespace abbe
