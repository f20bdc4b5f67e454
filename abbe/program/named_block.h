#pragma once

#include <optional>
#include <string_view>

#include "abbe/machine/profile.h"
#include "abbe/program/block.h"

namespace abbe {

/// Reads one line of a control whose words may have names (Profile::Text::names): "N10 G1 X=10.5 F250", "G2
/// X5 CR=7", "SUPA G0 Z0 D0", "MSG(\"..\")", "LABEL:", comments behind ';', archive lines "%_N_..". A code
/// that is a word becomes a Word of the letter G whose value is a tenth of its index in the profile, from its
/// first byte to its last, with all that is in its brackets; a value word with a name becomes the letter it
/// stands for. errors   the first reason why the line is not understood; `block` is then incomplete cost
/// about 60 ns for a line of three words, no allocation
[[nodiscard]] std::optional<BlockError> read_named_block(std::string_view line, const Profile& profile,
                                                         Block& block);

}  // namespace abbe
