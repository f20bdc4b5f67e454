#pragma once

#include <optional>

#include "abbe/machine/machine.h"

namespace abbe {

/// The index of a body by the axis part of an error's name (kToolBody and kWorkpieceBody for mountings);
/// nullopt if the chain has none.
[[nodiscard]] std::optional<int> body_of(const Machine& machine, const ErrorName& name);

/// The machine with one constant error of size 1 (mm or rad) and no other; nullopt: the name does not belong
/// to it.
[[nodiscard]] std::optional<Machine> with_unit_error(const Machine& machine, const ErrorName& name);

}  // namespace abbe
