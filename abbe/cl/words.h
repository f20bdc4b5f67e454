#pragma once

#include <optional>
#include <string_view>

namespace abbe::cl {

/// What Abbe does with a major word (docs/cl-data.md, table of records).
enum class Policy {
  pass,    ///< copied: it neither moves nor changes a frame
  follow,  ///< copied, and its state is kept: units, frames, modes, tools
  motion,  ///< its numbers are corrected
  refuse,  ///< known, and cannot be compensated
};

struct WordRule {
  std::string_view major;
  Policy policy;
  std::string_view why;  ///< refuse: the reason
};

/// The rule of a major word (upper case); nullopt for words that are not known.
[[nodiscard]] std::optional<WordRule> rule_of(std::string_view major);

}  // namespace abbe::cl
