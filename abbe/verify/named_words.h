#pragma once

#include <span>
#include <string_view>

#include "abbe/verify/block.h"

namespace abbe::verifying {

/// read_block for controls whose words have names: "X=10.5", "CR=7", "SUPA", "MSG(..)", "T=\"MILL\"", labels,
/// comments behind ';'. Written apart from the reader of the rewriter. errors   as read_block
[[nodiscard]] bool read_named_words(std::string_view line, const Profile& profile, Block& block, Fault& fault,
                                    std::span<const TcpCode> tcp_codes);

}  // namespace abbe::verifying
