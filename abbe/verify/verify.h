#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"
#include "abbe/core/progress.h"
#include "abbe/machine/control_setup.h"

namespace abbe {

/// probed: the work offset was touched off on this machine, so the deviation at its origin belongs to
/// the part's position and is subtracted. ideal: work offsets are true.
enum class DatumRule { probed, ideal };

struct VerifyJob {
  std::string original_path, output_path;  ///< files to read
  std::string original_name, output_name;  ///< what diagnostics call them
  ControlSetup setup;
  DatumRule datum = DatumRule::probed;
  bool reversal = false;             ///< direction-dependent errors by direction, not by their mean
  double tolerance = 1 * um;         ///< mm: interpolation and solution
  double max_correction = 500 * um;  ///< mm: a commanded point may not move farther than this
  std::size_t samples = 0;           ///< points to keep for figures, spread over the path; 0 = none
};

/// A point of the path as cut, for figures: where, and the deviation of the tool before and after.
struct PathSample {
  std::uint64_t line = 0;                            ///< of the original program
  Vec3 position = Vec3::Zero();                      ///< nominal tip, workpiece axes, mm
  double travelled = 0;                              ///< path length so far, mm
  Vec3 before = Vec3::Zero(), after = Vec3::Zero();  ///< deviation, mm
  bool rapid = false;
};

/// Largest and root-mean-square deviation over the feed motions, mm.
struct DeviationSummary {
  double max = 0, rms = 0;
  std::uint64_t max_line = 0;             ///< of the original program
  std::array<double, 3> max_component{};  ///< |x|, |y|, |z| each at its own worst place
};

struct DatumShift {
  std::string frame;            ///< "G54"
  int tool = -1;                ///< tool number, -1 = the machine file's tool
  Vec3 removed = Vec3::Zero();  ///< deviation at the work-offset origin, mm, workpiece axes
};

struct ProgramFacts {
  std::uint64_t lines = 0, bytes = 0;
  std::string sha256;
};

struct VerifyReport {
  bool agrees = false;      ///< path, events and their order, feeds and rapid/feed class are the same
  bool stopped = false;     ///< the caller asked to stop
  Diagnostics diagnostics;  ///< V-... codes for disagreements, E-... if a program was not understood
  ProgramFacts original, output;
  FileIdentity original_identity;
  DeviationSummary before, after;
  double direction_before = 0, direction_after = 0;  ///< largest angle of the tool axis while rotary axes turn, rad
  double quantisation = 0;  ///< mm: allowance for the digits of the output, largest used
  double allowed = 0;       ///< tolerance + quantisation, mm
  std::uint64_t feed_motions = 0, rapid_motions = 0, points = 0;  ///< compared
  std::uint64_t events = 0;                                       ///< non-motion events compared
  double path_length = 0;                                         ///< of feed motions, mm
  double lost_motion = 0;  ///< largest |forward - backward| deviation seen, mm
  std::vector<DatumShift> datums;
  std::vector<PathSample> samples;
};

/// Reads both programs with a reader that shares only number parsing with the rewriter, pushes the
/// output through the forward model and compares it with the original's nominal path: densely along
/// every feed motion, at the end of every rapid, all other events one by one.
/// cost    constant memory whatever the length
/// source  docs/theory/verification.md
[[nodiscard]] VerifyReport verify_program(const Plan& plan, const VerifyJob& job,
                                          const Progress& progress = {});

}  // namespace abbe
