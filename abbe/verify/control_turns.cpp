// Rotary words and tool centre point control.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/core/units.h"
#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

constexpr double kSamePlace = 1e-12;  // rad
constexpr double kHome = 0.5 * deg;   // a correction, and no more

constexpr char turn_letter(int axis) { return static_cast<char>('A' + axis); }

}  // namespace

bool Control::turn_words_allowed() {
  for (int k = 0; k < 3; ++k) {
    const char letter = turn_letter(k);
    if (!block_->has(letter)) continue;
    if (rotary_ == nullptr || !rotary_->declared())
      return refuse_at(letter, "E-ROTARY", fmt::format("rotary word {} without a declared mode", letter),
                       "X Y Z may be of the axes or of the tip", "state [control] mode in the machine file");
    if (!rotary_->has(k))
      return refuse_at(letter, "E-ROTARY", fmt::format("no rotary axis has the address {}", letter),
                       "where the tool goes is not known", "describe the axis in the machine file");
  }
  return true;
}

/// Takes A B C of a straight move or an arc.
bool Control::read_turns(bool machine_words) {
  for (int k = 0; k < 3; ++k) {
    const char letter = turn_letter(k);
    if (!block_->has(letter)) continue;
    if (!use(letter)) return false;
    const auto i = static_cast<std::size_t>(k);
    const Axes bit = Axes{1} << k;
    const double word = (*block_)[letter];
    const double offset = machine_words ? 0 : frames_.system().turns[i];
    if (incremental_ && !machine_words) {
      turns_[i] += word * deg;
    } else {
      if (rotary_->turning(k) == Turning::sign && offset != 0)
        return refuse_at(letter, "E-TURN", "a rotary offset on an axis whose sign is its direction",
                         "how the control adds them is not known", "set the offset to zero");
      const double to = rotary_->target(k, word, turns_[i], offset);
      turns_[i] = std::abs(to - turns_[i]) > kSamePlace || (unknown_turns_ & bit) != 0 ? to : turns_[i];
      unknown_turns_ &= ~bit;
    }
    motion_.named_turns |= bit;
    motion_.turn_words[i] = word;
    commanded_turns_ |= bit;
  }
  motion_.turns_end = turns_;
  return true;
}

/// The letters of the tool's direction in this block: those of its own words, or I J K where the mode says
/// so.
std::array<char, 3> Control::direction_letters() const {
  const bool mode = block_->tcp_code >= 0 ? block_->tcp && block_->tcp_vectors : directs_by_centre_words_;
  const int motion = block_->g_code(1) >= 0 ? block_->g_code(1) : mode_;
  const bool own = (block_->words & letter_set(kVectorLetters)) != 0;
  if (own || !mode || (motion != 0 && motion != 10))
    return {kVectorLetters[0], kVectorLetters[1], kVectorLetters[2]};
  return {'I', 'J', 'K'};
}

bool Control::direction_named() const {
  const auto named = direction_letters();
  return std::any_of(named.begin(), named.end(), [this](char letter) { return block_->has(letter); });
}

/// Takes the tool's direction of a straight move: where it turns the rotary axes.
bool Control::read_direction(bool machine_words) {
  const auto named = direction_letters();
  const auto refuse_it = [&](const char* message) {
    return refuse_at(named[0], "E-VECTOR", message, "where the rotary axes go is not sure",
                     "program the angles of the rotary axes");
  };
  Vec3 direction = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const char letter = named[static_cast<std::size_t>(i)];
    if (!block_->has(letter)) return refuse_it("a direction of the tool that lacks a component");
    if (!use(letter)) return false;
    direction[i] = (*block_)[letter];
    motion_.turn_words[static_cast<std::size_t>(i)] = direction[i];
  }
  if (turns_of_ == Meaning::turns_of_machine)
    return refuse_it("a direction of the tool while ORIMKS may make it one of the machine");
  const auto& offsets = frames_.system().turns;
  const bool offset = std::any_of(offsets.begin(), offsets.end(), [](double o) { return o != 0; });
  if (motion_.named_turns != 0) return refuse_it("a direction of the tool beside angles of rotary axes");
  if (rotary_ == nullptr || !tcp_ || machine_words || incremental_ || offset || !turns_known())
    return refuse_it("a direction of the tool where the control's way to read it is not sure");
  const ToolDirection::Found found =
      rotary_->direction().turns_for(rotated_about_z(direction, frames_.rotation()), turns_);
  if (found.problem != nullptr) return refuse_it(found.problem);
  turns_ = found.turns;
  for (int k = 0; k < 3; ++k)
    if (rotary_->has(k)) motion_.named_turns |= Axes{1} << k;
  commanded_turns_ |= motion_.named_turns;
  motion_.by_direction = true;
  motion_.turns_end = turns_;
  return true;
}

/// G28, G30: the axes named stand where only the control knows; none named: all.
void Control::forget_turns() {
  Axes named = 0;
  for (int k = 0; k < 3; ++k)
    if (block_->has(turn_letter(k))) named |= Axes{1} << k;
  if (named == 0 && motion_.named == 0) named = 7;
  if (rotary_ == nullptr) return;
  for (int k = 0; k < 3; ++k)
    if (!rotary_->has(k)) named &= ~(Axes{1} << k);
  unknown_turns_ |= named;
  commanded_turns_ |= named;
}

bool Control::turns_known() const { return unknown_turns_ == 0; }

/// The axes stay where they are; the position is of another point from now on.
bool Control::switch_tcp(bool on) {
  if (on == tcp_ || rotary_ == nullptr) return true;
  const auto map = rotary_->kinematics().axes_of_points(turns_, frames_.tool_offset.z());
  const auto back = map ? inverse(*map) : std::nullopt;
  if (!back)
    return refuse(1, "E-TCP", "the linear axes cannot follow the tip there",
                  "with the rotary axes at these positions they do not reach every point",
                  "check origins and directions in the machine file");
  tcp_ = on;
  // axes = map(point)
  m_.at = on ? (*back)(m_.at) : (*map)(m_.at);
  // Turned away from home the point depends on the control's numbers alone, and on every axis.
  const bool turned =
      std::any_of(turns_.begin(), turns_.end(), [](double turn) { return std::abs(turn) > kHome; });
  if (unknown_turns_ != 0 || turned) m_.known = 0;
  for (int i = 0; i < 3; ++i)
    if ((m_.known >> i & 1) == 0) m_.at[i] = 0;
  u_ = program_of(frames_, m_);
  return true;
}

}  // namespace abbe::verifying
