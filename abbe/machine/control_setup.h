#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/machine/machine.h"
#include "abbe/machine/profile.h"

namespace abbe {

/// One row of a LinuxCNC tool table, machine units already mm.
struct ToolEntry {
  int number = 0;
  int pocket = 0;
  std::array<double, 3> offset{};  ///< X Y Z, mm, what the control applies with H
  std::optional<double> gauge;     ///< `gauge=` in the comment or as a word, mm, >= 0
  double diameter = 0;
  std::string comment;
};

/// A work coordinate system: origin in machine coordinates (mm), rotation about Z (rad), and where A B C
/// are zero (rad).
struct WorkOffset {
  std::array<double, 3> origin{};
  double rotation = 0;
  std::array<double, 3> turns{};
};

/// What the control knows besides the program: given by the user, needed to know where the
/// machine's axes really stand. Positions are X Y Z in mm.
struct ControlSetup {
  std::shared_ptr<const Profile> profile;                 ///< the control; null = LinuxCNC
  std::array<std::optional<WorkOffset>, 9> work_offsets;  ///< G54 G55 G56 G57 G58 G59 G59.1 G59.2 G59.3
  std::map<int, WorkOffset> further_offsets;              ///< G54.1 P, G154 P: by number
  std::map<int, ToolEntry> tools;                         ///< by tool number
  std::map<int, double> gauges;                           ///< --gauge: tool number -> gauge length, mm
  std::map<int, double>
      radii;  ///< --radius: number of a D or tool -> cutter radius, mm; before the tool table
  std::optional<int> loaded_tool;  ///< in the spindle at the start; none = the machine file's tool
  std::array<std::optional<double>, 3> start;   ///< machine position before the program, if known
  std::array<double, 3> start_turns{};          ///< of A B C, rad
  enum class BlockDelete { unknown, on, off };  ///< on: blocks with '/' are skipped
  BlockDelete block_delete = BlockDelete::unknown;
  bool tool_change_keeps_place = false;  ///< false: after M6 no axis is known to stand where it was
};

/// The profile of the setup; LinuxCNC's where none is given.
[[nodiscard]] std::shared_ptr<const Profile> profile_of(const ControlSetup& setup);

/// Work offsets are counted 0..8 = G54 .. G59.3, 8 + n = the further one n (G54.1 P, G154 P).
inline constexpr int kFixedWorkOffsets = 9;
/// "G59.3", "G54.1 P12" by that count.
[[nodiscard]] std::string work_offset_label(int index);
/// The same the other way round: "G54" .. "G59.3", "G54.1P12" and "G154P12", "G505" .. "G599" (5 .. 99),
/// "G500" (100); nullopt otherwise.
[[nodiscard]] std::optional<int> work_offset_index(std::string_view name);

/// Reads a LinuxCNC tool table ("T1 P1 Z100.5 D10 ; mill gauge=112.4"). Lengths are in mm.
/// errors   words that are not understood, a tool twice, offsets of axes other than X Y Z
[[nodiscard]] Parsed<std::map<int, ToolEntry>> read_tool_table(const std::string& file,
                                                               const std::string& text);

/// Reads a LinuxCNC parameter file (var): G54..G59.3 origins and rotations (5221..5390), lengths in mm.
/// A work offset is set if the file holds any of its parameters; those it does not hold are 0.
/// errors   an active G92 offset and work offsets of axes other than X Y Z, which are not followed
[[nodiscard]] Parsed<ControlSetup> read_parameter_file(const std::string& file, const std::string& text);

/// The number of the tool whose comment says name="DRILL 8.5" (T="DRILL 8.5" in programs); the first of
/// several.
[[nodiscard]] std::optional<int> tool_named(const std::map<int, ToolEntry>& tools, std::string_view name);

/// The cutter radius of offset or tool `number`, mm: --radius, else half the diameter of the tool table.
/// nullopt: neither states it (a table's 0 does not). Negative where a table says so: to be refused.
[[nodiscard]] std::optional<double> cutter_radius(const ControlSetup& setup, int number);

/// The lever arm of the tool in the spindle (docs/machine-file.md, compensate): --gauge, else gauge=, else
/// the table's Z offset, else the machine file's length (tool number absent or not in any table).
struct GaugeLength {
  double length = 0;  ///< mm
  enum class Source { option, table_comment, table_offset, machine_file } source = Source::machine_file;
  bool touch_off = false;  ///< a negative table offset: not a length; refused when angular errors exist
};
[[nodiscard]] GaugeLength gauge_length(const ControlSetup& setup, const Machine& machine,
                                       std::optional<int> tool);

}  // namespace abbe
