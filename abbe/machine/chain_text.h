#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/machine/machine.h"
#include "abbe/machine/toml_document.h"

namespace abbe {

/// An element of the chain text between w, b and t.
struct ChainElement {
  std::string name;  ///< without prime
  Branch branch = Branch::tool;
  Mark mark;
};

/// Reads "w C X b Y Z A S t": blanks separate; w first, exactly one b, t last; an element is a capital
/// letter, then digits, then perhaps a prime, which is ignored. nullopt after a reported mistake.
[[nodiscard]] std::optional<std::vector<ChainElement>> read_chain(const TomlNode& node, Findings& findings);

/// What the first letter of an element says. Empty: the letter says nothing.
struct LetterDefaults {
  AxisType type = AxisType::linear;
  Vec3 direction = Vec3::UnitX();  ///< of a tool-branch axis
};
[[nodiscard]] std::optional<LetterDefaults> letter_defaults(char letter);

}  // namespace abbe
