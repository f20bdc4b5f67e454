// Tilted planes: coordinates of a plane in space, and rotary axes that stand square to it (3+2 machining).
//
//   v = M p + o + shift + work offset + tool offset          M = Rz(i) Rx(j) Rz(k), o the plane's origin
//
// While the rotary axes stand on the plane, v is a point of the tip as with tool centre point control
// (docs/theory/five-axes.md): a correction c of v is M^-1 c in the program.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "abbe/compensate/plane_turns.h"
#include "abbe/compensate/rewriter.h"
#include "abbe/core/units.h"
#include "abbe/program/swivel.h"

namespace abbe {
namespace {

// The angles of a plane and of the rotary axes are rounded to the control's digits: five half ones together.
constexpr double kRoundings = 2.5;
constexpr double kSameTurns = 1e-9;         // rad
constexpr std::size_t kShortestSwivel = 8;  // longer than the name of the code

Mat3 about(int axis, double angle) { return Eigen::AngleAxisd(angle, Vec3::Unit(axis)).toRotationMatrix(); }

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

// G68.2 X Y Z I J K.
bool Rewriter::tilt_plane() {
  Vec3 origin = Vec3::Zero(), angles = Vec3::Zero();
  bool complete = !modal_.incremental;
  for (int k = 0; k < 3; ++k) {
    const Word* place = axis_word(k);
    const Word* angle = instruction_.find(*block_, "IJK"[k]);
    complete = complete && place != nullptr && angle != nullptr;
    if (place != nullptr) origin[k] = place->value * modal_.unit();
    if (angle != nullptr) angles[k] = angle->value * deg;
  }
  if (!complete) {
    refuse_block("E-PLANE", "a tilted plane is followed with X Y Z I J K, in G90",
                 "what an absent word means depends on the control", "write all six, and G90 before");
    return false;
  }
  return declare_plane(about(2, angles[0]) * about(0, angles[1]) * about(2, angles[2]), origin);
}

bool Rewriter::declare_plane(const Mat3& turn, const Vec3& origin) {
  const char* reason = nullptr;
  const char* fix = "end the other frame before the plane";
  const Turns offset = in_.frames.turn_offset();
  if (!machine_.control.declared) {
    reason = "the machine file does not say where the control takes its rotary axes to be";
    fix = "declare [control] in the machine file";
  } else if (tcp_) {
    reason = "tool centre point control is on";
    fix = "switch it off before";
  } else if (in_.frames.placed() || in_.frames.turned() || in_.frames.rotated()) {
    reason = "another frame or a rotated work offset is in force";
  } else if (modal_.plane != Plane::xy) {
    reason = "G18 or G19 is in force";
    fix = "write G17 before";
  } else if (std::any_of(offset.begin(), offset.end(), [](double shift) { return shift != 0; })) {
    reason = "the work offset shifts a rotary axis: what the plane is then fixed to depends on the control";
    fix = "use a work offset whose A, B and C are zero";
  } else if (job_.reversal && field_.depends_on_direction()) {
    reason = "which machine axes turn round on the plane is not followed";
    fix = "leave --reversal away";
  }
  if (reason != nullptr) {
    refuse_block("E-PLANE", "a tilted plane cannot begin here", reason, fix);
    return false;
  }
  place(turn, origin);
  plane_ = PlaneStage::declared;
  turned_by_words_ = false;
  move_text_ = "a tilted plane begins: X Y Z are of it when the rotary axes stand on it";
  return true;
}

// PLANE SPATIAL: M = Rz(K) Ry(J) Rx(I), about the datum.
bool Rewriter::spatial_plane() {
  const auto angle = [&](char letter) {
    const Word* word = instruction_.find(*block_, letter);
    return word != nullptr ? word->value * deg : 0.0;
  };
  if (!declare_plane(about(2, angle('K')) * about(1, angle('J')) * about(0, angle('I')), Vec3::Zero()))
    return false;
  const Word* side = instruction_.find(*block_, 'Q');
  const Word* turns = instruction_.find(*block_, 'P');
  turned_by_words_ = turns == nullptr || turns->value == 0;
  if (turned_by_words_) return true;
  // without SEQ this control takes the nearer way: sure only where the tool stands on the plane already
  return side != nullptr ? tool_to_plane(side->value < 0 ? -1 : 1) : tool_to_plane(std::nullopt, true);
}

// CYCLE800(..): a new one takes the place of the one before.
bool Rewriter::swivel_plane() {
  std::optional<Swivel> swivel;
  for (int i = 0; i < block_->count && !swivel; ++i) {
    const Word& word = block_->words[static_cast<std::size_t>(i)];
    const std::string_view said =
        block_->text.substr(word.begin, static_cast<std::size_t>(word.end - word.begin));
    if (word.letter == 'G' && said.size() > kShortestSwivel) swivel = read_swivel(said);
  }
  if (!swivel || (!swivel->ends && in_.frames.g92() != Vec3::Zero())) {
    refuse_block(
        "E-PLANE", "a swivelled plane in a form that is not followed, or with TRANS in force",
        "where the plane lies, and how the tool gets there, is not sure",
        "write TRANS, then CYCLE800(..,\"NAME\",0,57,X0,Y0,Z0,A,B,C,X1,Y1,Z1,DIR): axis by axis, literal "
        "numbers");
    return false;
  }
  if (plane_ != PlaneStage::none) end_plane();
  if (swivel->ends) return true;
  Mat3 turn = Mat3::Identity();
  for (std::size_t i = 0; i < 3; ++i) turn = turn * about(swivel->axes[i], swivel->angles[i] * deg);
  if (!declare_plane(turn, modal_.unit() * (swivel->before + turn * swivel->behind))) return false;
  turned_by_words_ = swivel->direction == 0;
  return turned_by_words_ || tool_to_plane(swivel->direction);
}

// PLANE RESET: where the axes go if the control turns them back is not followed.
bool Rewriter::reset_plane() {
  end_plane();
  const Word* turns = instruction_.find(*block_, 'P');
  if (turns == nullptr || turns->value == 0) return true;
  known_ &= 7u;
  turned_ |= needed_ >> 3;
  return true;
}

// G53.1: the control turns the rotary axes itself. They end where they stand already, but for the digits of
// their words and a correction of them; or where the machine file says.
bool Rewriter::tool_to_plane(std::optional<int> side, bool stands) {
  if (plane_ != PlaneStage::declared) {
    refuse_block("E-PLANE", "the tool is sent to a plane that is not declared, or stands on it already",
                 "where the rotary axes go is not known", "write G68.2 X.. Y.. Z.. I.. J.. K.. before");
    return false;
  }
  const unsigned rotary = needed_ & ~7u;
  const PlaneTurns turns(field_.control(), axes_, field_.tool());
  const Vec3 normal = in_.frames.matrix().col(2);
  std::optional<Turns> target;
  if (auto tilt = machine_.control.tilt; tilt && !stands) {
    tilt->sign = side.value_or(tilt->sign);
    target = turns.on_side(normal, in_.turns, *tilt);
  } else if ((known_ & rotary) == rotary && !side) {
    if (!stands_on_plane(in_.turns)) return false;
    target = turns.near(normal, in_.turns);
  }
  if (!target) {
    refuse_block("E-PLANE", "where the rotary axes go is not fixed",
                 "the correction depends on where they really stand, and there is more than one way",
                 "command them before the plane (G0 A.. C..), or state tilt_solution in [control]");
    return false;
  }
  known_ |= rotary;
  turned_ |= rotary >> 3;
  in_.turns = out_.turns = *target;
  plane_ = PlaneStage::stands;
  switch_tcp(true);
  forget(7);
  return stand(in_.turns, out_.turns);
}

// The program turns the rotary axes to the plane itself: they must stand there when X, Y or Z moves.
bool Rewriter::stand_on_plane() {
  unsigned named = 0;
  for (int k = 0; k < 3; ++k) named |= axis_word(k) ? 1u << k : 0u;
  if (plane_ != PlaneStage::declared || named == 0) return true;
  const unsigned rotary = needed_ & ~7u;
  if (!turned_by_words_ || instruction_.turns_axes || (known_ & rotary) != rotary) {
    refuse_block(
        "E-PLANE", "X, Y or Z on a tilted plane before the tool stands on it",
        "the tool would not be square to the plane",
        "write G53.1 behind G68.2; turn the rotary axes in a block of their own behind PLANE .. STAY");
    return false;
  }
  if (!stands_on_plane(in_.turns)) return false;
  double corrected = 0;
  for (std::size_t k = 0; k < 3; ++k) corrected = std::max(corrected, std::abs(in_.turns[k] - out_.turns[k]));
  if (corrected > kSameTurns) {
    refuse_block("E-PLANE", "the rotary axes were turned, and corrected, before the plane",
                 "whether the control reckons with where they stand or with the plane is not sure",
                 "turn them behind the plane: PLANE .. STAY, then L A.. C.. FMAX");
    return false;
  }
  plane_ = PlaneStage::stands;
  switch_tcp(true);
  forget(7);
  return stand(in_.turns, out_.turns);
}

// The commanded rotary positions bring the control's tool square to the plane.
bool Rewriter::stands_on_plane(const Turns& turns) {
  double increment = 0;
  for (int k = 0; k < 3; ++k) {
    if (axes_.rotary[static_cast<std::size_t>(k)] >= 0)
      increment = std::max(increment, std::pow(10.0, -turn_decimals(k)) * deg);
  }
  const Vec3 direction = PlaneTurns(field_.control(), axes_, field_.tool()).tool_direction(turns);
  const double off = angle_between(direction, in_.frames.matrix().col(2));
  if (off <= kRoundings * increment) return true;
  refuse_block("E-PLANE",
               fmt::format("the rotary axes as commanded leave the tool {:.4f} deg off the plane", off / deg),
               "the control would turn them elsewhere, and the program does not say where",
               "command them so that the tool stands on the plane, check `direction` of the rotary axes, or "
               "state tilt_solution in [control]");
  return false;
}

void Rewriter::end_plane() {
  for (auto* side : {&in_, &out_}) side->frames.place_nothing();
  if (plane_ == PlaneStage::stands) switch_tcp(false);
  plane_ = PlaneStage::none;
  drop_pole();
  forget(7);
}

// False: refused. On a plane the rotary axes stay.
bool Rewriter::plane_allows(const Move& move) {
  if (plane_ == PlaneStage::stands && move.turns()) {
    refuse_block("E-PLANE", "a rotary axis turns while the tool stands on a tilted plane",
                 "the plane would turn with it, or not, as the control is set", "end the plane before (G69)");
    return false;
  }
  return true;
}

}  // namespace abbe
