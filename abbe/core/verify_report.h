#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"
#include "abbe/core/linear_algebra.h"

/// What the verification of a corrected program says, whichever verifier ran: that of G code or that of CL
/// data. Both count alike (path_tally.h) and read by themselves.
namespace abbe {

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

/// The part's place: what the machine's error at the work offset's origin moved it by.
struct DatumShift {
  std::string frame;            ///< "G54"
  int tool = -1;                ///< tool number, -1 = the machine file's tool
  Vec3 removed = Vec3::Zero();  ///< deviation at the work-offset origin, mm, workpiece axes
};

/// A text as it was read to its end.
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
  double direction_before = 0,
         direction_after = 0;  ///< largest angle of the tool axis, where it is compared, rad
  double quantisation = 0;     ///< mm: allowance for the digits of the output, largest used
  double allowed = 0;          ///< tolerance + quantisation, mm
  std::uint64_t feed_motions = 0, rapid_motions = 0, points = 0;  ///< compared
  std::uint64_t together = 0;  ///< of feed_motions: judged side by side with their neighbours
  std::uint64_t events = 0;    ///< compared that are no motions
  double path_length = 0;      ///< of feed motions, mm
  double lost_motion = 0;      ///< largest |forward - backward| deviation seen, mm
  std::vector<DatumShift> datums;
  std::vector<PathSample> samples;
};

/// Adds a shift unless it is there, up to kMostDatums: a program may change its tool as often as it likes.
inline constexpr std::size_t kMostDatums = 1000;
void note_datum(std::vector<DatumShift>& datums, const DatumShift& shift);

}  // namespace abbe
