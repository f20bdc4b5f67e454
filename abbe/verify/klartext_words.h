#pragma once

#include <span>
#include <string_view>

#include "abbe/verify/block.h"

namespace abbe::verifying {

/// read_block for conversational programs: "12 L X+10 IZ-5 R0 FMAX M3", "CC X+0 Y+0", "C X+5 DR-", "TOOL CALL
/// 1 Z S900", "CYCL DEF 247 ~". Written apart from the reader of the rewriter: the line is cut at its blanks
/// first. `continued` is what the lines before have left open. errors   as read_block
[[nodiscard]] bool read_klartext_words(std::string_view line, const Profile& profile, Continued continued,
                                       Block& block, Fault& fault, std::span<const TcpCode> tcp_codes);

/// What the line leaves open for the next one.
[[nodiscard]] Continued continued_after(std::string_view line, Continued before);

/// The line without its block number and the blanks around it; `number` is it, or -1.
[[nodiscard]] std::string_view behind_block_number(std::string_view line, long& number);

}  // namespace abbe::verifying
