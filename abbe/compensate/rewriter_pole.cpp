// Arcs of conversational programs: CC says the pole, C goes about it. The pole is written with the arc that
// needs it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/compensate/rewriter.h"

namespace abbe {
namespace {

constexpr double kLookSpacing = 10;  // mm along an arc
constexpr int kFewestLooks = 24;
constexpr int kMostChords = 4096;
// Of the interpolation's share: so much may be missing across an arc, the rest is for its plane.
constexpr double kAcross = 0.7;

}  // namespace

void Rewriter::set_pole() {
  const double unit = modal_.unit();
  pole_in_ = pole_out_ = Centre{block_->words[0].value * unit, block_->words[1].value * unit};
  held_pole_ = std::make_unique<HeldPole>();
  held_pole_->text = std::string(block_->text);
  held_pole_->eol = std::string(eol_);
  held_pole_->block = *block_;
  held_pole_->block.text = held_pole_->text;
}

void Rewriter::release_pole(std::string& out) {
  out += held_pole_->text;
  out += held_pole_->eol;
  ++report_.lines_out;
  held_pole_.reset();
}

// The frame has changed: whether the pole moves with it is not sure.
void Rewriter::drop_pole() { pole_in_ = pole_out_ = std::nullopt; }

// A block CC in front of an arc: the one that was held back, or another one if the pole in force does not do.
void Rewriter::place_pole(const Centre& centre, std::string& before) {
  const int decimals = decimals_of(nullptr);
  double base = 0;
  const std::array<Value, 2> values = {centre_value(0, centre.a, Vec3::Zero(), true, base),
                                       centre_value(1, centre.b, Vec3::Zero(), true, base)};
  const bool moved = values[0].written || values[1].written;
  std::array<double, 2> read = {values[0].number, values[1].number};
  if (held_pole_) {
    LineEdit edit;
    edit.reset(held_pole_->block);
    for (std::size_t k = 0; k < 2; ++k)
      if (values[k].written) read[k] = edit.replace(held_pole_->block.words[k], read[k], decimals);
    edit.append_to(before);
    before += held_pole_->eol;
    held_pole_.reset();
  } else if (moved) {
    before += "CC X";
    read[0] = append_number(before, read[0], decimals, block_->style);
    before += " Y";
    read[1] = append_number(before, read[1], decimals, block_->style);
    before += file_eol_.empty() ? "\n" : file_eol_;
  } else {
    return;
  }
  ++report_.lines_out;
  pole_out_ = Centre{read[0] * modal_.unit(), read[1] * modal_.unit()};
}

void Rewriter::begin_pole_arc(const ArcPiece& piece, std::string& before, std::string& extra) {
  if (piece.keeps_radius) return;
  place_pole(piece.centre, before);
  if (!piece.first) {
    extra = " C";
  } else if (const Word* r = instruction_.find(*block_, 'R')) {  // CR, whose radius does not say it well
    edit_.replace(block_->words[0]) = "C";
    edit_.remove(*r);
  }
}

void Rewriter::end_pole_arc(bool first, std::string& extra) {
  if (!first) extra += instruction_.motion == 20 ? " DR-" : " DR+";
}

// The arc stays in its plane: does the correction leave it?
std::optional<bool> Rewriter::leaves_plane(const Arc& nominal, double height) {
  const int looks = std::max(kFewestLooks, static_cast<int>(std::ceil(nominal.length() / kLookSpacing)));
  for (int k = 0; k <= std::min(looks, kMostChords); ++k) {
    const Vec3 at = in_.frames.to_machine(nominal.at(static_cast<double>(k) / looks));
    const auto c = correction_at(at, withheld_, approach_);
    if (!c) return std::nullopt;
    const double off = std::abs(out_.frames.to_program(at + *c).z() - height);
    if (off * in_.frames.stretch() > kAcross * interpolation_) return true;
  }
  return false;
}

// The arc as lines, whose middle is off by r (1 - cos(sweep / 2 n)), r as on the machine.
bool Rewriter::chords(const Arc& nominal, std::string& out, Vec3& p_out) {
  const double r = std::max(nominal.r0, nominal.r1) * in_.frames.stretch();
  const double step = 2 * std::acos(std::max(0.0, 1 - interpolation_ / r));
  const double count = std::ceil(std::abs(nominal.sweep) / step);
  if (!(count <= kMostChords)) {
    refuse_block("E-TOL", fmt::format("the arc leaves its plane, and would become {:.0f} lines", count),
                 "C and CR stay in their plane, and the correction across it changes along the arc",
                 "post the arc as lines, or allow more with --tolerance-um");
    return false;
  }
  Move move;
  move.m0 = in_.frames.to_machine(nominal.at(0));
  move.m1 = in_.frames.to_machine(nominal.at(1));
  edit_.replace(block_->words[0]) = "L";
  for (int i = 1; i < block_->count; ++i) {
    const Word& word = block_->words[static_cast<std::size_t>(i)];
    const std::string_view said = block_->text.substr(word.begin, 2);
    if (word.letter == 'R' || (word.letter == 'G' && said == "DR")) edit_.remove(word);
  }
  pieces_.clear();
  const int n = std::max(2, static_cast<int>(count));
  if (1.0 / n < splitting_.least)
    return refuse_short_blocks(interpolation_ * std::pow(n * splitting_.least, 2));
  for (int k = 1; k <= n; ++k) {
    const double s = static_cast<double>(k) / n;
    const Vec3 at = in_.frames.to_machine(nominal.at(s));
    const auto c = correction_at(at, withheld_, approach_);
    if (!c) return false;
    pieces_.push_back({static_cast<double>(k - 1) / n, s, out_.frames.to_program(at + *c), {}, {}});
  }
  if (held_pole_) release_pole(out);
  write_pieces(move, pieces_, out);
  p_out = out_.p();
  if (number_ == job_.trace_line)
    move_text_ = fmt::format("arc in {} lines: the correction leaves its plane", n);
  return true;
}

}  // namespace abbe
