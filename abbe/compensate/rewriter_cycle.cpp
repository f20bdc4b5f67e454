#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"

namespace abbe {

// The control makes the motions of a cycle itself: X Y Z R are shifted together by the correction at
// mid-depth of the hole, if the correction is the same everywhere in it (docs/theory/compensation.md).
void Rewriter::cycle(std::string& out) {
  Holes holes;
  if (!read_holes(holes)) return;
  withheld_ &= ~(1u << holes.n);
  for (const int k : {holes.a, holes.b}) {
    if (axis_word(k)) withheld_ &= ~(1u << k);
  }
  refresh_datum();
  const auto last_approach = approach_;
  // X and Y come to the hole as the way there goes, the cycle's axis downwards.
  Vec3 way = in_.frames.vector_to_machine(holes.first - in_.p());
  way[holes.n] = holes.z - holes.r;
  follow(way, 7);
  if (approach_ != stands_) last_correction_.reset();  // it was for the other direction

  Vec3 shift = Vec3::Zero(), end_out = out_.p();
  double r_out = holes.r;
  const auto residual = shift_of(holes, shift);
  const bool expands =
      residual && (cycle_.expanded || (job_.expand_drill && *residual > job_.tolerance && drills()));
  if (expands) {
    approach_ = last_approach;  // Z goes down when the tool is above the hole
    if (expand_holes(holes, out)) return;
  }
  const bool shifted = residual && !expands && keeps_shape(*residual) &&
                       holds_withheld(in_.frames.to_machine((holes.first + holes.last()) / 2), "a cycle");
  if (shifted) {
    note_way_out(holes, shift);
    r_out = write_holes(holes, shift, out, end_out);
  }

  Vec3 end = holes.last();
  end[holes.n] = modal_.retract_to_r ? holes.r : std::max(in_.cycle_level, holes.r);
  end_out[holes.n] = modal_.retract_to_r ? r_out : std::max(out_.cycle_level, r_out);
  in_.m = in_.frames.to_machine(end);
  // Refused: nothing is written any more, but what follows is judged from where it starts.
  out_.m = shifted ? out_.frames.to_machine(end_out) : in_.m;
  stands_ = approach_;
  Vec3 up = Vec3::Zero();
  up[holes.n] = end[holes.n] - holes.z;
  follow(up, 7);
  last_correction_.reset();
  start_corrected_ = shifted && withheld_ == 0;
}

// What the words of the block and those that are still in force mean. False: refused.
bool Rewriter::read_holes(Holes& holes) {
  holes.a = plane_axes(modal_.plane)[0];
  holes.b = plane_axes(modal_.plane)[1];
  holes.n = plane_axes(modal_.plane)[2];
  const GCode code = instruction_.motion;
  const double unit = modal_.unit();
  const Word* wl = instruction_.find(*block_, profile_.cycles.repeats);
  const auto bad = [&](const char* what, const char* why, const char* fix) {
    refuse_block("E-CYCLE", what, why, fix);
    return false;
  };
  const Vec3 p = in_.p();
  // As in LinuxCNC the height before the whole sequence is what G98 returns to and what R adds to in G91.
  if (cycle_.code < 0) {
    in_.cycle_level = p[holes.n];
    out_.cycle_level = out_.p()[holes.n];
  }
  if (cycle_.code != code) {
    Cycle fresh;
    if (cycle_.code >= 0) {  // the sequence goes on
      fresh.expanded = cycle_.expanded;
      fresh.dwell = cycle_.dwell;
      fresh.dwells = cycle_.dwells;
    }
    cycle_ = std::move(fresh);
    cycle_.code = code;
  }
  take_dwell();
  if (cycle_.refused) return false;  // its first block was: one cause, one finding
  cycle_.refused = true;             // until it has been understood
  if (!feed_above_zero()) return false;
  if (!keep_depth(holes.n)) return false;
  if (profile_.cycles.xy_only && modal_.plane != Plane::xy) {
    return bad("a cycle outside the XY plane",
               "which axis it drills along depends on the control's parameters", "drill in G17");
  }
  if ((code == 740 || code == 840) && modal_.plane != Plane::xy) {
    return bad("tapping outside the XY plane", "LinuxCNC moves other axes than the program names",
               "tap in G17");
  }
  if (!cycle_.has_r || !cycle_.has_z)
    return bad("the first block of a cycle needs R and the bottom", "the control refuses it", "add them");
  if (known_ != needed_) {
    refuse_block("E-POS", "a cycle while the position of an axis is not known",
                 "the correction depends on all three axes",
                 "begin with rapid moves that name X, Y and Z, or give the machine's position with --start "
                 "X..,Y..,Z..");
    return false;
  }
  if (!in_.frames.known()) {
    Move unused;
    return read_move(unused);  // reports the missing work offset
  }
  if (in_.frames.rotated() && (modal_.plane != Plane::xy || (withheld_ & 3u))) {
    refuse_block("E-ROTATION", "a cycle in a rotated work offset needs the XY plane",
                 "it is not a motion of the machine's axes", "set the offset without rotation");
    return false;
  }
  if (in_.frames.stretch() != 1 && plane_ == PlaneStage::none)
    return bad("a cycle while a scale is in force", "which of its numbers are scaled is not sure",
               "post the holes as G0 and G1, or scale in the CAM system");
  if (code == 760 && frame_kind_ != FrameChange::none)
    return bad("a fine bore in a mirrored frame", "to which side the tool is moved away is not sure",
               "post the hole as G0 and G1, or mirror in the CAM system");
  cycle_.refused = false;
  const double repeats = wl ? wl->value : 1;
  if (repeats < 1 || repeats > 9999 || repeats != std::floor(repeats))
    return bad("the repeats of a cycle are a number from 1 to 9999", "the holes are not defined",
               "correct the word");
  holes.times = static_cast<int>(repeats);
  holes.count = modal_.incremental ? static_cast<int>(repeats) : 1;
  const bool relative = modal_.incremental && !keeps_levels();
  holes.r = cycle_.r * unit + (relative ? in_.cycle_level : 0.0);
  holes.z = cycle_.z * unit + (relative ? holes.r : 0.0);
  if (!profile_.cycles.level_below_r && in_.cycle_level < holes.r) {
    return bad("the cycle begins below its R level", "controls differ in where it ends then",
               "go above R before");
  }
  if (holes.z > holes.r)
    return bad("the bottom of the hole lies above R", "the control refuses it", "check Z and R");
  holes.first = p;
  for (const int k : {holes.a, holes.b}) {
    const Word* word = axis_word(k);
    if (!word) continue;
    if (modal_.incremental) holes.step[k] = word->value * unit;
    holes.first[k] = word->value * unit + (modal_.incremental ? p[k] : 0.0);
  }
  return true;
}

// Takes R and the bottom of the block into the sequence, as numbers or as the levels they make.
bool Rewriter::keep_depth(int n) {
  const Word* wr = instruction_.find(*block_, 'R');
  const Word* wz = axis_word(n);
  const bool levels = keeps_levels();
  const bool same_mode = profile_.cycles.sticky == Profile::Sticky::same_mode;
  const bool begun = cycle_.has_r && cycle_.has_z;
  if (levels && begun && modal_.incremental && (wr == nullptr) != (wz == nullptr)) {
    refuse_block("E-CYCLE", "R or the bottom alone in G91", "whether the other one moves with it is not sure",
                 "give both");
    return false;
  }
  if (same_mode && begun && modal_.incremental != cycle_.incremental && (!wr || !wz)) {
    refuse_block("E-CYCLE", "G90 and G91 change inside a sequence of cycles",
                 "what R and Z mean then is not sure", "give R and Z again");
    return false;
  }
  const double base = levels && modal_.incremental ? 1.0 : 0.0;
  if (wr) cycle_.r = wr->value + base * in_.cycle_level / modal_.unit();
  if (wz) cycle_.z = wz->value + base * cycle_.r;
  if (wr || wz) cycle_.incremental = modal_.incremental;
  cycle_.has_r = cycle_.has_r || wr;
  cycle_.has_z = cycle_.has_z || wz;
  return true;
}

// The shift of all holes of the block, program coordinates.
std::optional<double> Rewriter::shift_of(const Holes& holes, Vec3& shift) {
  const auto at_height = [&](Vec3 at, double h) {
    at[holes.n] = h;
    return in_.frames.to_machine(at);
  };
  const Vec3 middle = at_height((holes.first + holes.last()) / 2, (holes.r + holes.z) / 2);
  const auto c = correction_at(middle, withheld_, approach_);
  if (!c) return std::nullopt;
  note_correction(middle, *c);
  shift = in_.frames.vector_to_program(*c);
  if (holes.count > 1) {
    // the same word steps to every hole: it cannot take up a correction
    const Vec3 stands = out_.p() - in_.p();
    for (const int k : {holes.a, holes.b}) shift[k] = stands[k];
  }
  double residual = 0;
  Vec3 at = holes.first;
  for (int i = 0; i < holes.count; ++i) {
    for (const double h : {holes.r, holes.z}) {
      const auto there = correction_at(at_height(at, h), withheld_, approach_);
      if (!there) return std::nullopt;
      residual = std::max(residual, (in_.frames.vector_to_program(*there) - shift).norm());
    }
    at += holes.step;
  }
  return residual;
}

// False, and said: the control makes these motions, and the correction changes in them.
bool Rewriter::keeps_shape(double residual) {
  report_.cycle_residual = std::max(report_.cycle_residual, residual);
  if (residual > job_.tolerance) {
    refuse_block("E-CYCLE",
                 fmt::format("the correction changes by {:.2f} um inside this cycle", residual / um),
                 "the control makes the motions of the cycle itself, so it can only be shifted as a whole",
                 drills() ? "--expand-drill writes such holes as G0 and G1; or allow more with --tolerance-um"
                          : "post the holes as G0 and G1, or allow more with --tolerance-um");
    return false;
  }
  move_text_ =
      fmt::format("cycle: shifted as a whole by the correction at mid-depth; {:.2f} um of it change inside",
                  residual / um);
  return true;
}

// On the way out the drill is led by the hole: what the correction for the way up is aside of the shift
// remains, too. Along the hole it cuts nothing any more.
void Rewriter::note_way_out(const Holes& holes, const Vec3& shift) {
  std::array<signed char, 3> upwards = approach_;
  upwards[static_cast<std::size_t>(holes.n)] = 1;
  if (!job_.reversal || !field_.depends_on_direction()) return;
  for (const double h : {holes.r, holes.z}) {
    Vec3 at = (holes.first + holes.last()) / 2;
    at[holes.n] = h;
    const auto there = correction_at(in_.frames.to_machine(at), withheld_, upwards);
    if (!there) return;
    Vec3 aside = in_.frames.vector_to_program(*there) - shift;
    aside[holes.n] = 0;
    report_.cycle_residual = std::max(report_.cycle_residual, aside.norm());
  }
}

// Returns the R level of the output; `p_out` becomes the place of its last hole.
double Rewriter::write_holes(const Holes& holes, const Vec3& shift, std::string& out, Vec3& p_out) {
  const double unit = modal_.unit();
  // X and Y like any other move; the hole's depth words apart
  const Vec3 from = p_out;
  command(holes.first + shift, true, p_out, nullptr, 1u << holes.n);
  // R, then the bottom measured from R where increments are programmed
  const Word* wr = instruction_.find(*block_, 'R');
  const Word* wz = axis_word(holes.n);
  const double r_base = modal_.incremental ? out_.cycle_level : 0.0;
  const bool levels = keeps_levels();
  Value r = value_for((holes.r + shift[holes.n] - r_base) / unit, wr,
                      cycle_.r_out - (levels ? r_base / unit : 0.0), decimals_of(wr));
  const auto bottom = [&](double r_level) {
    const double z_base = modal_.incremental ? r_level : 0.0;
    return value_for((holes.z + shift[holes.n] - z_base) / unit, wz,
                     cycle_.z_out - (levels ? z_base / unit : 0.0), decimals_of(wz));
  };
  // Where levels are kept, increments are given together.
  if (levels && modal_.incremental && !wr && bottom(r_base + r.number * unit).written) r.written = true;
  if (r.written) r.number = put('R', wr, r.number, decimals_of(wr), true, nullptr);
  const double r_out = r_base + r.number * unit, z_base = modal_.incremental ? r_out : 0.0;
  Value z = bottom(r_out);
  if (levels && modal_.incremental && !wz && r.written) z.written = true;
  if (z.written) z.number = put("XYZ"[holes.n], wz, z.number, decimals_of(wz), true, nullptr);
  cycle_.r_out = r.number + (levels ? r_base / unit : 0.0);
  cycle_.z_out = z.number + (levels ? z_base / unit : 0.0);

  const std::size_t begin = out.size();
  edit_.append_to(out);
  end_line(out, begin);
  if (edit_.changed()) ++report_.blocks.rewritten;
  for (const int k : {holes.a, holes.b}) p_out[k] += (holes.count - 1) * (p_out[k] - from[k]);
  return r_out;
}

}  // namespace abbe
