#pragma once

#include <cstdint>
#include <span>

#include "abbe/chain/control_kinematics.h"
#include "abbe/core/linear_algebra.h"

namespace abbe::verifying {

/// What a plain block leads to: axis words and perhaps N, G1 and a feed, where G1 is in force already, while
/// positions are absolute axis commands, F is per minute and every rotary axis counts as it is written.
struct PlainMotion {
  Vec3 u = Vec3::Zero();       ///< program position + g92, mm
  Vec3 m = Vec3::Zero();       ///< axis commands, mm
  Turns turns{};               ///< rad
  double feed = 0;             ///< in force, program units
  bool states_feed = false;    ///< the block has an F
  bool states_number = false;  ///< the block has an N
  double number = 0;
  unsigned named_turns = 0;  ///< A B C with a word in the block: bits 0 1 2
};

/// The plain motions of lines that were read together.
struct PlainRun {
  std::span<const PlainMotion> motions;
  std::size_t next = 0;      ///< the first one that is still to come
  std::uint64_t serial = 0;  ///< another number: other motions
  [[nodiscard]] std::size_t left() const { return motions.size() - next; }
};

}  // namespace abbe::verifying
