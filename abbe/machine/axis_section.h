#pragma once

#include <vector>

#include "abbe/machine/chain_text.h"
#include "abbe/machine/machine.h"
#include "abbe/machine/toml_document.h"

namespace abbe {

/// What later checks need to know about the text of one axis.
struct AxisNotes {
  Mark mark;   ///< its key in the axis table, else its word in the chain
  Mark order;  ///< of the explicit order
  bool explicit_order = false;
};

struct AxisSection {
  std::vector<Body> bodies;      ///< in chain order
  std::vector<AxisNotes> notes;  ///< one per body
};

/// Reads every [axis.*] and gives each chain element its defaults. After a mistake, which is
/// reported, the default of that key is used.
[[nodiscard]] AxisSection read_axes(const TomlNode& root, const std::vector<ChainElement>& chain,
                                    const FileUnits& units, Findings& findings);

/// The word of a factor in `order`, without its minus: "static" for component.
[[nodiscard]] std::string_view factor_word(FactorKind kind);

}  // namespace abbe
