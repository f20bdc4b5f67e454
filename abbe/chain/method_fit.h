#pragma once

#include <optional>
#include <string>

#include "abbe/chain/correct.h"

namespace abbe {

/// Why a method of `correct` cannot serve these free axes of this chain, in words that end a sentence
/// "the method closed-form does not fit: ..."; nullopt if it can. Newton and one step serve every chain.
///
/// closed_form  rigid model; three linear axes that span space and at most two rotary ones, which are not
///              parallel and of which the one near the tool does turn the tool. Any branches, any order,
///              any skew. Where locked rotary axes stand between, the answer depends on the command: such
///              chains are accepted here and points that do not fit are held or fail.
/// printed      the chain of seed 003 with errors of its 53 only (printed_form.h)
/// cost         allocates; ask once, not per point
[[nodiscard]] std::optional<std::string> method_obstacle(Method method, const Machine& machine,
                                                         ErrorModel model, const Tool& tool, AxisSet free);

}  // namespace abbe
