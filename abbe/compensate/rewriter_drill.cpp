#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/compensate/rewriter.h"

// A hole whose correction changes inside it, written as the motions that its cycle makes:
// rapid above the hole, rapid to R, feed to the bottom, dwell, rapid back, rapid to the level of G98 or G99.
namespace abbe {
namespace {

constexpr std::size_t kG9 = 90;
constexpr std::size_t kG4 = 40;
// Heights that differ by less are the same: places of one program, reckoned two ways, mm.
constexpr double kSameHeight = 1e-7;

}  // namespace

// P counts for all dwelling cycles of a sequence.
void Rewriter::take_dwell() {
  const Word* p = instruction_.find(*block_, 'P');
  if (p == nullptr) return;
  cycle_.dwell = block_->text.substr(p->begin, static_cast<std::size_t>(p->end - p->begin));
  cycle_.dwells = p->value > 0;
}

// False, and said: what the cycle does is not sure, or G0, G1 and G4 cannot do it.
bool Rewriter::may_expand(const Holes& holes) {
  const bool dwells = cycle_.code == 820 && cycle_.dwells;
  const CodeUse& g4 = profile_.g[kG4];
  const bool g4_takes_p = g4.meaning == Meaning::dwell && (g4.words & letter_set("P")) != 0;
  const char* why = !drills()                 ? "it follows holes that are written as G0 and G1"
                    : modal_.feed_mode == 930 ? "it would need a time for each block (G93)"
                    : in_.frames.placed()     ? "the plane is tilted, scaled or mirrored"
                    : withheld_ != 0          ? "an axis stands in machine coordinates"
                    : in_.p()[holes.n] < holes.r - kSameHeight ? "it begins below its R level"
                    : dwells && !(profile_.cycles.dwell_as_g4 && g4_takes_p)
                        ? "the profile does not say that G4 counts its P as the cycle does"
                        : nullptr;
  if (why == nullptr) return true;
  refuse_block("E-CYCLE", fmt::format("this cycle cannot be written as G0 and G1: {}", why),
               "the correction changes inside it, or did in a hole of the same sequence",
               "write G80 and go to the initial level before it, or post the holes as G0 and G1");
  return false;
}

// False: refused, and nothing is written.
bool Rewriter::expand_holes(const Holes& holes, std::string& out) {
  if (!may_expand(holes)) return false;
  Expansion expansion;
  expansion.at = in_.p();
  expansion.p_out = out_.p();
  Vec3 hole = holes.first;
  for (int i = 0; i < holes.times; ++i) {
    if (!drill(holes, hole, expansion)) return false;
    hole += holes.step;
  }
  write_expansion(expansion, out);
  report_.expanded_holes += static_cast<std::uint64_t>(holes.times);
  cycle_.expanded = true;
  move_text_ = "cycle: written as the motions that it makes, for the correction changes inside the hole";
  in_.m = in_.frames.to_machine(expansion.at);
  out_.m = out_.frames.to_machine(expansion.p_out);
  stands_ = approach_;
  last_correction_.reset();
  start_corrected_ = true;
  return true;
}

bool Rewriter::drill(const Holes& holes, const Vec3& hole, Expansion& expansion) {
  const auto at_height = [&](double h) {
    Vec3 at = hole;
    at[holes.n] = h;
    return at;
  };
  const Vec3 down = -Vec3::Unit(holes.n), r = at_height(holes.r), bottom = at_height(holes.z);
  const Vec3 above = at_height(expansion.at[holes.n]);
  if (!go_rapidly(above, above - expansion.at, expansion) || !go_rapidly(r, down, expansion)) return false;

  // The way down, straight where the correction is.
  Move move;
  move.m0 = in_.frames.to_machine(r);
  move.m1 = in_.frames.to_machine(bottom);
  const auto c = correction_at(move.m1, 0, approach_);
  if (!c || !sample_line(move, *c, approach_)) return false;
  last_correction_.reset();
  note_correction(move.m1, *c);
  std::vector<std::size_t> ends = split_move(samples_, interpolation_);
  measure_split((move.m1 - move.m0).norm());
  if (!keep_block_time(ends)) return false;
  std::vector<double> places;
  const bool dwells = cycle_.code == 820 && cycle_.dwells;
  const bool stops = profile_.g[kG9].meaning == Meaning::exact_stop_once;
  for (const std::size_t end : ends) {
    const MoveSample& sample = samples_[end];
    const Vec3 m = move.m0 + sample.s * (move.m1 - move.m0) + sample.correction;
    const bool last = end == ends.back();
    write_stroke(last && !dwells && stops ? " G9 G1" : " G1", out_.frames.to_program(m), expansion);
    places.push_back(sample.s);
  }
  // The control may round the corner between feed and rapid: the bottom is reached first.
  if (dwells) {
    expansion.blocks.push_back(" G4 " + cycle_.dwell);
  } else if (!stops) {
    expansion.blocks.emplace_back(" G4 P0");
  }
  expansion.at = bottom;

  const Vec3 up = -down;
  for (std::size_t i = places.size() - 1; i-- > 0;) {
    if (!go_rapidly(r + places[i] * (bottom - r), up, expansion)) return false;
  }
  const double level = modal_.retract_to_r ? holes.r : std::max(in_.cycle_level, holes.r);
  return go_rapidly(r, up, expansion) && (level == holes.r || go_rapidly(at_height(level), up, expansion));
}

// A rapid to a place of the original's program coordinates, reached in the direction `way`.
bool Rewriter::go_rapidly(const Vec3& to, const Vec3& way, Expansion& expansion) {
  follow(in_.frames.vector_to_machine(way), 7);
  const Vec3 m = in_.frames.to_machine(to);
  const auto c = correction_at(m, 0, approach_);
  if (!c) return false;
  write_stroke(" G0", out_.frames.to_program(m + *c), expansion);
  expansion.at = to;
  return true;
}

// The block of the original becomes the first rapid: its words of the cycle go, those of axes say the place.
void Rewriter::write_first(const Vec3& want, Expansion& expansion) {
  expansion.first = false;
  for (int i = 0; i < block_->count; ++i) {
    const Word& word = block_->words[static_cast<std::size_t>(i)];
    const bool cycle = word.letter == 'R' || word.letter == 'P' || word.letter == profile_.cycles.repeats;
    if (cycle) edit_.remove(word);
    if (word.letter == 'G' && instruction_.states_motion && word.value * 10 == cycle_.code)
      edit_.replace(word) = "0";
  }
  if (!instruction_.states_motion && !cycle_.expanded) edit_.add("G0");
  const int n = plane_axes(modal_.plane)[2];
  command(want, true, expansion.p_out, nullptr, 1u << n);
  // the word of the depth goes, or says the height at which the tool gets there
  double base = 0;
  const Word* depth = axis_word(n);
  Value height = axis_value(n, want, expansion.p_out, false, base);
  if (height.written) {
    height.number = put("XYZ"[n], depth, height.number, decimals_of(depth), true, nullptr);
    expansion.p_out[n] = base + height.number * modal_.unit();
  } else if (depth != nullptr) {
    edit_.remove(*depth);
  }
  stops_to_last(true, nullptr);
}

void Rewriter::write_stroke(std::string words, const Vec3& want, Expansion& expansion) {
  if (expansion.first) return write_first(want, expansion);
  const std::size_t bare = words.size();
  command(want, false, expansion.p_out, &words);
  if (words.size() > bare) expansion.blocks.push_back(std::move(words));  // empty: it stands there
}

void Rewriter::write_expansion(const Expansion& expansion, std::string& out) {
  const std::string_view inner_eol = file_eol_.empty() ? std::string_view("\n") : std::string_view(file_eol_);
  const std::string_view line_eol = eol_;
  std::size_t begin = out.size();
  edit_.append_to(out);
  eol_ = inner_eol;
  end_line(out, begin);
  eol_ = line_eol;
  for (std::size_t i = 0; i < expansion.blocks.size(); ++i) {
    std::string words = expansion.blocks[i];
    const bool last = i + 1 == expansion.blocks.size();
    if (last) stops_to_last(false, &words);
    add_block(words, last ? eol_ : inner_eol, out);
  }
  ++report_.blocks.rewritten;
}

}  // namespace abbe
