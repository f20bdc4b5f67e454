#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/cl/interpreter.h"
#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"
#include "abbe/core/progress.h"
#include "abbe/core/units.h"
#include "abbe/machine/control_setup.h"

namespace abbe {

struct ClVerifyJob {
  std::string original_path, output_path;  ///< files to read
  std::string original_name, output_name;  ///< what findings call them
  ControlSetup setup;
  cl::Conventions conventions;
  std::array<double, kMaxAxes> start{};
  bool probed_datum = true;
  double tolerance = 1 * um;         ///< mm: interpolation and solution
  double max_correction = 500 * um;  ///< mm, of the tip
  std::size_t samples = 0;           ///< points to keep for figures; 0 = none
};

/// Deviation of the tip over feed motions and of the tool axis at their ends.
struct ClDeviation {
  double max = 0, rms = 0;                ///< mm
  std::uint64_t max_line = 0;             ///< of the original
  std::array<double, 3> max_component{};  ///< workpiece axes, each at its own worst place, mm
  double max_angle = 0;                   ///< rad
};

struct ClSample {
  std::uint64_t line = 0;
  Vec3 position = Vec3::Zero();                      ///< nominal tip, workpiece axes, mm
  double travelled = 0;                              ///< mm
  Vec3 before = Vec3::Zero(), after = Vec3::Zero();  ///< mm
  bool rapid = false;
};

struct ClFile {
  std::uint64_t lines = 0, bytes = 0;
  std::string sha256;
};

struct ClVerifyReport {
  bool agrees = false;
  bool stopped = false;
  Diagnostics diagnostics;  ///< V-... for disagreements, E-... if a file was not understood
  ClFile original, output;
  FileIdentity original_identity;
  ClDeviation before, after;
  double quantisation = 0;  ///< mm
  double allowed = 0;       ///< mm
  std::uint64_t feed_motions = 0, rapid_motions = 0, points = 0, records = 0;
  double path_length = 0;                    ///< of feed motions, mm
  std::vector<std::pair<int, Vec3>> datums;  ///< tool number (-1: none) and deviation removed, mm
  std::vector<ClSample> samples;
};

/// Reads both CL files with a reader that shares only number parsing with the rewriter's, turns the output
/// into commands as an ideal post-processor does, pushes them through the model with all errors, and compares
/// the tip with the original's path: densely along feed motions, at the ends of rapids, at depth and
/// clearance of holes. All other records must be the same, byte for byte and in the same order. errors  V-...
/// disagreements (20 at most), E-... records that are not understood cost    constant memory whatever the
/// length source  docs/theory/cl-data.md
[[nodiscard]] ClVerifyReport verify_cl(const Plan& plan, const ClVerifyJob& job,
                                       const Progress& progress = {});

}  // namespace abbe
