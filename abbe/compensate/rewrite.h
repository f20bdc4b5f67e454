#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"
#include "abbe/core/progress.h"
#include "abbe/machine/control_setup.h"

namespace abbe {

struct RewriteJob {
  std::string path;  ///< program to read
  std::string name;  ///< what diagnostics call it
  ControlSetup setup;
  bool probed_datum = true;
  bool reversal = false;
  double tolerance = 1 * um;         ///< mm; half of it is spent on interpolation
  double max_correction = 500 * um;  ///< mm
  double max_gradient = 1e-3;        ///< mm per mm
  std::vector<std::string> header;   ///< comment lines to put at the top, after '%' and the O word
  std::uint64_t trace_line = 0;      ///< explain this line of the program; 0 = none
};

/// What happened to one block, for `abbe explain`.
struct BlockTrace {
  std::string frame;                              ///< "G54"
  Vec3 frame_origin = Vec3::Zero(), g92 = Vec3::Zero(), tool_offset = Vec3::Zero(), datum = Vec3::Zero();  ///< mm
  std::optional<int> tool;
  double gauge_length = 0;                        ///< mm
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();  ///< axis commands of the original, mm
  Vec3 correction = Vec3::Zero();                 ///< at the end, mm
  std::string decision;                           ///< in words
  std::string before, after;                      ///< text
};

struct RewriteReport {
  bool complete = false;  ///< false: refused or stopped, the output is worthless
  bool stopped = false;
  Diagnostics diagnostics;
  FileIdentity identity;
  std::uint64_t lines_in = 0, bytes_in = 0, lines_out = 0;
  std::string sha256_in;  ///< set by the pipeline, which reads the file before
  struct Blocks {
    std::uint64_t motion = 0, rewritten = 0, split = 0, passed = 0;
  } blocks;
  std::uint64_t arcs_in = 0, arcs_out = 0;
  std::array<double, 3> max_correction{};        ///< per X Y Z, mm
  std::array<std::uint64_t, 3> max_line{};
  double max_gradient = 0;                       ///< mm per mm
  double cycle_residual = 0;                     ///< mm, inside canned cycles (rigid shift)
  std::uint64_t held_blocks = 0;                 ///< with a rotary axis held near a singularity
  double shortest_split = 0;                     ///< mm, 0 = nothing split
  std::optional<BlockTrace> trace;
  bool compensated_input = false;                ///< the input carries our mark
  bool out_of_volume = false;                    ///< some refusal is E-VOL or E-TRAVEL (exit code 5)
};

/// Rewrites a program so that the machine's errors cancel: edits the digits of coordinate words, adds
/// words or blocks only where needed, copies every other byte. Lines go to `out` in order.
/// cost    constant memory whatever the length
/// source  docs/theory/compensation.md
[[nodiscard]] RewriteReport rewrite_program(const Plan& plan, const RewriteJob& job, SpoolFile& out,
                                            const Progress& progress = {});

}  // namespace abbe
