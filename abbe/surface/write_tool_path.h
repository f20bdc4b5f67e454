#pragma once

#include <optional>
#include <string>

#include "abbe/machine/profile.h"
#include "abbe/surface/tool_path.h"

namespace abbe {

/// What goes around the points.
struct ToolPathText {
  std::string name;         ///< of the part, for a comment
  double radius = 3;        ///< mm
  double feed = 1000;       ///< mm/min
  double clearance = 5;     ///< mm above the highest tip: where the tool goes from pass to pass
  std::optional<int> tool;  ///< loaded and its length used; none: it is in the spindle, and the control knows
};

/// The path as CL data (APT): UNITS, CUTTER, FEDRAT, RAPID and GOTO of the tip, part coordinates, six
/// decimals.
/// laws     Parts.ClDataOfAPathAreRead (tests/cli)
[[nodiscard]] std::string write_cl(const ToolPath& path, const ToolPathText& text);

/// The path as a program of G0 and G1 in the first work offset, with the codes and digits of the control. It
/// does not switch spindle or coolant, and says so in a comment.
/// errors   nullopt: the profile has no code for one of rapid, line, mm, absolute, feed per minute, program
///          end; or, to load a tool, for tool change or tool length
/// laws     ProgramsSpeakTheControlsLanguage
[[nodiscard]] std::optional<std::string> write_program(const ToolPath& path, const ToolPathText& text,
                                                       const Profile& profile);

}  // namespace abbe
