#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"
#include "abbe/core/linear_algebra.h"

/// What the rewriting of a program says, of G code (its blocks) as of CL data (its records).
namespace abbe {

/// What happened to one block or record, for `abbe explain`.
struct BlockTrace {
  std::string frame;  ///< "G54"
  Vec3 frame_origin = Vec3::Zero(), g92 = Vec3::Zero(), tool_offset = Vec3::Zero(),
       datum = Vec3::Zero();  ///< mm
  std::optional<int> tool;
  double gauge_length = 0;                        ///< mm
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();  ///< of the original: axis commands or tips, mm
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
    std::uint64_t together = 0;  ///< of `motion`: corrected side by side with their neighbours
  } blocks;
  std::uint64_t arcs_in = 0, arcs_out = 0;
  std::array<double, 3> max_correction{};  ///< per X Y Z, mm
  std::array<std::uint64_t, 3> max_line{};
  double max_gradient = 0;           ///< mm per mm
  double cycle_residual = 0;         ///< mm, inside canned cycles (rigid shift)
  std::uint64_t held_blocks = 0;     ///< or records, with a rotary axis held near a singularity
  std::uint64_t expanded_holes = 0;  ///< of drilling cycles that became G0, G1 and G4
  double shortest_split = 0;         ///< mm, 0 = nothing split
  double shortest_split_time = 0;    ///< s: least time of such a piece; 0: nothing split, or F not known
  std::uint64_t held_splits = 0;     ///< motions that have fewer pieces than the tolerance asks for, for time
  double held_residual = 0;          ///< mm: what remains in them
  double cutter_radius = 0;          ///< mm, largest that the control offsets the path by
  double cutter_residual = 0;        ///< mm, across the path: correction at the cutter's centre minus at the contour
  /// How much farther off the tool is, at the worst of the places where the corrections were largest, per mm
  /// that the stated work offset or gauge length differs from the true one; mm per mm. None with rotary axes.
  struct Sensitivity {
    double offset = 0, length = 0;
  };
  std::optional<Sensitivity> sensitivity;
  std::optional<BlockTrace> trace;
  bool compensated_input = false;  ///< the input carries our mark
  bool out_of_volume = false;      ///< some refusal is E-VOL or E-TRAVEL (exit code 5)
};

}  // namespace abbe
