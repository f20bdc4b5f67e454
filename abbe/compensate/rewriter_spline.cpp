// NURBS (G6.2): blocks of control points and knots that make one curve. The blocks are held back until the
// last knot has come; then the control points are moved by the correction of the places that follow them
// most, and knots and weights stay as they are (docs/theory/compensation.md).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

constexpr std::size_t kMostBlocks = 100000;
// Places of the curve that are looked at: along each span of knots, and each so far from the next, mm.
constexpr double kLookSpacing = 1;
constexpr int kFewestLooks = 8, kMostLooks = 2000;
// Numbers of a program that are the same place, mm.
constexpr double kSamePlace = 1e-6;

}  // namespace

/// What the block says of its curve: a knot, and a control point unless it is one of the last knots.
bool Rewriter::hold_spline_block() {
  const bool begins = !spline_;
  const Word* const k = instruction_.find(*block_, 'K');
  const auto refuse_spline = [&](const char* message, const char* fix) {
    refuse_block("E-SPLINE", message, "the curve that the control makes of it is not known", fix);
    return false;
  };
  if (begins && !instruction_.states_motion)
    return refuse_spline("a block behind the last knot of a curve", "write G0, G1, G2, G3 or G6.2");
  if (!begins && instruction_.states_motion)
    return refuse_spline("a curve begins before the last one has all its knots", "complete the knots");
  if (modal_.incremental || modal_.feed_mode == 930 || block_->slash || increments() != 0)
    return refuse_spline("a curve in G91, in G93 or in blocks with '/'",
                         "post it in G90 and G94, without '/'");
  if (k == nullptr) return refuse_spline("a block of a curve without its knot K", "write K into every block");
  if (begins) {
    spline_ = std::make_unique<HeldSpline>();
    const Word* const p = instruction_.find(*block_, 'P');
    spline_->curve.order = p == nullptr ? 4 : static_cast<int>(std::clamp(p->value, 0.0, 100.0));
    if (p != nullptr && p->value != spline_->curve.order)
      return refuse_spline("P is no whole number", "correct P");
    spline_->at = in_.p();
    for (int axis = 0; axis < 3; ++axis) spline_->axes |= axis_word(axis) != nullptr ? 1u << axis : 0u;
  } else if (instruction_.find(*block_, 'P') != nullptr) {
    return refuse_spline("P inside a curve", "write it into the first block only");
  }
  HeldSpline& held = *spline_;
  if (held.blocks.size() == kMostBlocks)
    return refuse_spline("a curve of too many blocks", "break it into several");
  held.curve.knots.push_back(k->value);
  unsigned named = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Word* const word = axis_word(axis);
    if (word == nullptr) continue;
    named |= 1u << axis;
    held.at[axis] = word->value * modal_.unit();
  }
  if ((named & ~held.axes) != 0)
    return refuse_spline("an axis that the first block of the curve does not name", "name all axes there");
  if (named != 0) {
    if (held.curve.knots.size() != held.curve.points.size() + 1)
      return refuse_spline("a control point behind the last knots of a curve", "correct the knots");
    held.curve.points.push_back(held.at);
    const Word* const r = instruction_.find(*block_, 'R');
    held.curve.weights.push_back(r == nullptr ? 1 : r->value);
  } else if (instruction_.find(*block_, 'R') != nullptr) {
    return refuse_spline("a weight without a control point", "correct the block");
  }
  hold_line(named != 0);
  return true;
}

/// The line as it stands, to be written when the curve is known.
void Rewriter::hold_line(bool has_point) {
  auto held = std::make_unique<HeldSpline::Line>();
  held->text = std::string(block_->text);
  held->eol = std::string(eol_);
  held->block = *block_;
  held->block.text = held->text;
  held->instruction = instruction_;
  held->number = number_;
  held->has_point = has_point;
  spline_->blocks.push_back(std::move(held));
}

void Rewriter::spline(std::string& out) {
  if (motion_lost_) return;  // a block of a curve that was refused
  if (in_.frames.placed() || tcp_) {
    refuse_block("E-SPLINE", "a curve in a tilted, scaled or mirrored frame, or of the tip (G43.4, G43.5)",
                 "what becomes of it is not followed", "post the curve as lines");
    return abandon_spline();
  }
  Move move;
  if (!read_move(move)) return;
  if (!hold_spline_block()) return abandon_spline();
  const NurbsCurve& curve = spline_->curve;
  if (curve.knots.size() < curve.points.size() + static_cast<std::size_t>(std::max(2, curve.order))) return;
  if (!write_spline(out)) return abandon_spline();
  in_.m = in_.frames.to_machine(curve.points.back());
  start_corrected_ = true;
  last_correction_.reset();
  stands_ = approach_;
  spline_.reset();
}

/// After a refusal nothing is written any more; what follows is judged from where the curve was to go.
void Rewriter::abandon_spline() {
  if (spline_) out_.m = in_.m = in_.frames.to_machine(spline_->at);
  spline_.reset();
  motion_lost_ = true;
  start_corrected_ = false;
  last_correction_.reset();
}

/// Where the control points of the output shall be, program coordinates. The first is where the tool stands.
std::optional<std::vector<Vec3>> Rewriter::moved_points() {
  const NurbsCurve& curve = spline_->curve;
  std::vector<Vec3> wanted;  // corrections at the places that follow the control points most
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const Vec3 m = in_.frames.to_machine(place_on(curve, greville(curve, i)));
    const auto c = correction_at(m, withheld_, approach_);
    if (!c) return std::nullopt;
    note_correction(m, *c);
    wanted.push_back(out_.frames.vector_to_program(*c));
  }
  std::vector<Vec3> points = shifts_through(curve, wanted);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += curve.points[i];
  points.front() = out_.p();
  return points;
}

/// How far the tip is off along the curve, mm; nothing: it cannot be told (refused).
std::optional<double> Rewriter::spline_miss(const NurbsCurve& output) {
  const NurbsCurve& curve = spline_->curve;
  double length = 0, worst = 0;
  for (std::size_t i = 1; i < curve.points.size(); ++i)
    length += (curve.points[i] - curve.points[i - 1]).norm();
  const auto spans = curve.points.size();
  const int looks =
      std::clamp(static_cast<int>(std::ceil(length / kLookSpacing / static_cast<double>(spans))),
                 kFewestLooks, kMostLooks);
  for (std::size_t k = 0; k + 1 < curve.knots.size(); ++k) {
    const double from = curve.knots[k], width = curve.knots[k + 1] - from;
    for (int i = 0; width > 0 && i <= looks; ++i) {
      const double u = from + width * i / looks;
      const auto miss =
          field_.miss(in_.frames.to_machine(place_on(curve, u)), out_.frames.to_machine(place_on(output, u)));
      if (miss.outside) {
        report_.out_of_volume = true;
        refuse_block("E-VOL", "the curve leaves the calibrated volume", "beyond it the errors are not known",
                     "check the work offset (--offset), or measure a larger volume");
        return std::nullopt;
      }
      worst = std::max(worst, miss.position);
    }
  }
  return worst;
}

bool Rewriter::write_spline(std::string& out) {
  HeldSpline& held = *spline_;
  const auto refuse_spline = [&](std::string message, const char* why, const char* fix) {
    refuse_block("E-SPLINE", std::move(message), why, fix);
    return false;
  };
  if (const std::string fault = fault_of(held.curve); !fault.empty())
    return refuse_spline("no curve that is sure: " + fault, "the control stops, or makes another one",
                         "correct knots, points and order");
  if ((held.curve.points.front() - in_.p()).norm() > kSamePlace)
    return refuse_spline("the first control point is not where the tool stands", "the control stops there",
                         "begin the curve at the end of the motion before");
  if (known_ != needed_ || withheld_ != 0)
    return refuse_spline("a curve from a place that is not known in all axes", "its correction is not known",
                         "command X, Y and Z before");
  if (field_.depends_on_direction() && job_.reversal)
    return refuse_spline("lost motion along a curve",
                         "an axis that turns round inside it cannot be corrected",
                         "post lines, or correct without --reversal");
  const auto points = moved_points();
  if (!points) return false;
  NurbsCurve moved = held.curve;
  std::string text;
  Vec3 p_out = out_.p();
  std::size_t point = 0;
  Block* const last = block_;
  const std::string_view last_eol = eol_;
  const std::uint64_t last_number = number_;
  for (const auto& line : held.blocks) {
    block_ = &line->block;
    instruction_ = line->instruction;
    eol_ = line->eol;
    number_ = line->number;
    edit_.reset(*block_);
    if (line->has_point) {
      command((*points)[point], true, p_out, nullptr, ~held.axes);
      moved.points[point++] = p_out;
    }
    const std::size_t begin = text.size();
    edit_.append_to(text);
    end_line(text, begin);
    if (edit_.changed()) ++report_.blocks.rewritten;
  }
  block_ = last;
  eol_ = last_eol;
  number_ = last_number;
  if ((moved.points.front() - out_.p()).norm() > kSamePlace)
    return refuse_spline("the first control point cannot be written with the digits of the place before it",
                         "the control stops there", "post both with the same digits");
  const auto miss = spline_miss(moved);
  if (!miss) return false;
  const double allowed = interpolation_ + std::sqrt(3.0) * half_digit(decimals_of(nullptr)) * modal_.unit();
  if (!(*miss <= allowed))
    return refuse_spline(
        fmt::format("moved control points leave the curve {:.3f} um off, {:.3f} um are allowed", *miss / um,
                    allowed / um),
        "the correction bends between its knots, or its weights differ much",
        "post the curve with more knots or as lines, or allow more with --tolerance-um");
  follow(in_.frames.to_machine(held.curve.points.back()) -
             in_.frames.to_machine(held.curve.points[held.curve.points.size() - 2]),
         known_);
  out_.m = out_.frames.to_machine(p_out);
  out += text;
  return true;
}

}  // namespace abbe
