#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"

namespace abbe {

// The control makes the motions of a cycle itself: X Y Z R are shifted together by the correction at
// mid-depth of the hole, if the correction is the same everywhere in it (docs/theory/compensation.md).
void Rewriter::cycle(std::string& out) {
  const int a = plane_axes(modal_.plane)[0], b = plane_axes(modal_.plane)[1], n = plane_axes(modal_.plane)[2];
  const GCode code = instruction_.motion;
  const double unit = modal_.unit();
  const bool first = cycle_.code != code;
  const Word* wr = instruction_.find(block_, 'R');
  const Word* wz = axis_word(n);
  const Word* wl = instruction_.find(block_, 'L');
  const auto bad = [&](const char* what, const char* why, const char* fix) { refuse_block("E-CYCLE", what, why, fix); };
  if ((code == 740 || code == 840) && modal_.plane != Plane::xy) {
    return bad("tapping outside the XY plane", "LinuxCNC moves other axes than the program names", "tap in G17");
  }
  if (first && (!wr || !wz)) return bad("the first block of a cycle needs R and the bottom", "the control refuses it", "add them");
  const double repeats = wl ? wl->value : 1;
  if (repeats < 1 || repeats > 9999 || repeats != std::floor(repeats)) return bad("L of a cycle is a number of repeats, 1 to 9999", "the holes are not defined", "correct L");
  if (known_ != 7) {
    refuse_block("E-POS", "a cycle while the position of an axis is not known", "the correction depends on all three axes",
                 "begin with rapid moves that name X, Y and Z, or give the machine's position with --start X..,Y..,Z..");
    return;
  }
  if (!in_.frames.known()) {
    Move unused;
    static_cast<void>(read_move(unused));  // reports the missing work offset
    return;
  }
  if (in_.frames.rotated() && (modal_.plane != Plane::xy || (withheld_ & 3u))) {
    refuse_block("E-ROTATION", "a cycle in a rotated work offset needs the XY plane", "it is not a motion of the machine's axes", "set the offset without rotation");
    return;
  }
  const Vec3 p = in_.p(), p_out = out_.p();
  // As in LinuxCNC the height before the whole sequence is what G98 returns to and what R adds to in G91.
  if (cycle_.code < 0) {
    in_.cycle_level = p[n];
    out_.cycle_level = p_out[n];
  }
  const double r_word = wr ? wr->value : cycle_.r, z_word = wz ? wz->value : cycle_.z;
  const double r = r_word * unit + (modal_.incremental ? in_.cycle_level : 0.0);
  const double z = z_word * unit + (modal_.incremental ? r : 0.0);
  if (z > r) return bad("the bottom of the hole lies above R", "the control refuses it", "check Z and R");
  const auto count = static_cast<int>(repeats);
  Vec3 step = Vec3::Zero(), hole = p;
  for (const int k : {a, b}) {
    if (const Word* word = axis_word(k)) {
      if (modal_.incremental) step[k] = word->value * unit;
      else hole[k] = word->value * unit;
    }
  }
  if (modal_.incremental) hole += step;
  const Vec3 last_hole = modal_.incremental ? Vec3(hole + (count - 1) * step) : hole;

  withheld_ &= ~(1u << n);
  for (const int k : {a, b}) {
    if (axis_word(k)) withheld_ &= ~(1u << k);
  }
  refresh_datum();
  const auto at_height = [&](Vec3 at, double h) {
    at[n] = h;
    return in_.frames.to_machine(at);
  };
  const Vec3 middle = at_height((hole + last_hole) / 2, (r + z) / 2);
  const auto c = correction_at(middle, withheld_, approach_);
  if (!c) return;
  note_correction(middle, *c);
  Vec3 shift = in_.frames.vector_to_program(*c);
  if (modal_.incremental && count > 1) {
    // the same word steps to every hole: it cannot take up a correction
    for (const int k : {a, b}) shift[k] = p_out[k] - p[k];
  }
  double residual = 0;
  Vec3 at = hole;
  for (int i = 0; i < count; ++i) {
    for (const double h : {r, z}) {
      const auto there = correction_at(at_height(at, h), withheld_, approach_);
      if (!there) return;
      residual = std::max(residual, (in_.frames.vector_to_program(*there) - shift).norm());
    }
    if (!modal_.incremental) break;
    at += step;
  }
  report_.cycle_residual = std::max(report_.cycle_residual, residual);
  if (residual > job_.tolerance) {
    refuse_block("E-CYCLE", fmt::format("the correction changes by {:.2f} um inside this cycle", residual / um),
                 "the control makes the motions of the cycle itself, so it can only be shifted as a whole",
                 "post the holes as G0 and G1, or allow more with --tolerance-um");
    return;
  }

  // X and Y like any other move; the hole's depth words apart
  Vec3 at_out = p_out;
  command(hole + shift, true, at_out, nullptr, 1u << n);
  const auto depth_word = [&](const Word* word, char letter, double wanted, double present) {
    const Value value = value_for(wanted, word, present, decimals_of(word));
    if (value.written) put(letter, word, value.number, decimals_of(word), true, nullptr);
    return value.number;
  };
  // R, then the bottom measured from R where increments are programmed
  const double r_base = modal_.incremental ? out_.cycle_level : 0.0;
  cycle_.r_out = depth_word(wr, 'R', (r + shift[n] - r_base) / unit, cycle_.r_out);
  const double r_out = r_base + cycle_.r_out * unit;
  const double z_base = modal_.incremental ? r_out : 0.0;
  cycle_.z_out = depth_word(wz, "XYZ"[n], (z + shift[n] - z_base) / unit, cycle_.z_out);
  cycle_.r = r_word;
  cycle_.z = z_word;
  cycle_.code = code;

  const std::size_t begin = out.size();
  edit_.append_to(out);
  end_line(out, begin);
  if (edit_.changed()) ++report_.blocks.rewritten;
  Vec3 end = last_hole, end_out = at_out;
  if (modal_.incremental && count > 1) {
    for (const int k : {a, b}) end_out[k] = at_out[k] + (count - 1) * (at_out[k] - p_out[k]);
  }
  end[n] = modal_.retract_to_r ? r : std::max(in_.cycle_level, r);
  end_out[n] = modal_.retract_to_r ? r_out : std::max(out_.cycle_level, r_out);
  in_.m = in_.frames.to_machine(end);
  out_.m = out_.frames.to_machine(end_out);
  last_correction_.reset();
  start_corrected_ = withheld_ == 0;
  move_text_ = fmt::format("cycle: shifted as a whole by the correction at mid-depth; {:.2f} um of it change inside", residual / um);
}

}  // namespace abbe
