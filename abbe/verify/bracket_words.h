#pragma once

#include <string>
#include <string_view>

#include "abbe/verify/hole_words.h"

namespace abbe::verifying {

/// The number of a drilling cycle with brackets by its name in any case ("CYCLE83"), 0: none that is known.
[[nodiscard]] int bracket_cycle(std::string_view name);

/// Takes "CYCLE81(RTP, RFP, SDIS, DP, DPR, ..)" into the words of a cycle as place_of() reads them: the place
/// of the surface is RFP, what is above and below it counts from there; other arguments stand as 301, 302 and
/// so on. Written apart from the rewriter's. errors   false, `fault` says why: an argument that is no number,
/// a depth that is not one, a mode not known
[[nodiscard]] bool take_brackets(std::string_view text, HoleWords& words, std::string& fault);

}  // namespace abbe::verifying
