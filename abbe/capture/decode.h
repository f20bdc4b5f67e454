#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "abbe/capture/process_map.h"
#include "abbe/capture/survey.h"
#include "abbe/core/progress.h"

namespace abbe {

/// Which clock the time of a row is from.
enum class TimeBase {
  recorder,  ///< when the recording computer saw the frame
  esl,       ///< when the switch link (ET2000, CU2508) saw it, ns
  clock,     ///< the bus' reference clock, read in the same frame (0x0910), ns
};
[[nodiscard]] std::string_view to_string(TimeBase base);

/// The best clock of a capture: esl if every EtherCAT frame carries a time, else clock if every returning
/// frame with process data does, else recorder.
[[nodiscard]] TimeBase best_time_base(const CaptureSurvey& survey);

/// Some rows, column by column.
struct ColumnBlock {
  std::span<const double> time;                  ///< s since the first row
  std::vector<std::span<const double>> columns;  ///< of each object of the plan, in its unit
};
/// Returning false stops the decoding.
using ColumnSink = std::function<bool(const ColumnBlock&)>;

struct DecodeOptions {
  TimeBase base = TimeBase::recorder;
  /// Rows in which a slave did not answer (working counter too small) are dropped, for their inputs are old
  /// or 0.
  bool keep_short = false;
};

/// What will be decoded: the objects that this capture carries.
struct DecodePlan {
  std::vector<PdoObject> columns;
  std::vector<PdoObject> inputs;     ///< all of the map, also those without a column: they may hide outputs
  std::vector<std::string> missing;  ///< objects of the map that no frame carries
  /// Outputs that cannot be told from the inputs at the same address, because no frame on its way out is
  /// recorded.
  std::vector<std::string> hidden;
};
[[nodiscard]] DecodePlan plan_columns(const ProcessMap& map, const CaptureSurvey& survey);

struct Gap {
  std::uint64_t row = 0;  ///< the first row behind it, from 0
  double time = 0;        ///< of that row, s
  double length = 0;      ///< s since the row before
};

struct DecodeReport {
  std::uint64_t rows = 0;
  std::uint64_t short_rows = 0;       ///< a working counter was too small
  std::uint64_t incomplete_rows = 0;  ///< a datagram of the cycle is missing
  std::uint64_t untimed_rows = 0;     ///< dropped: the chosen clock was not in the frame
  std::uint64_t backward = 0;         ///< rows whose time is not behind that of the row before
  std::uint64_t bad_frames = 0;
  std::uint64_t gap_count = 0;
  std::vector<Gap> gaps;             ///< the first kMostGaps: longer than 1.5 cycles
  std::int64_t first_ns = 0;         ///< time of the first row in the clock's own counting
  std::optional<std::string> error;  ///< the capture is broken behind the last row
  bool stopped = false;              ///< by the sink or progress
  static constexpr std::size_t kMostGaps = 100;
};

/// Process data, one row per bus cycle: inputs from returning frames, outputs from the frames on their way
/// out. A cycle begins with first_of_cycle and is complete when every process datagram that carries a column
/// has come back.
///
/// plan     of plan_columns, for the same survey; survey of the same file (a partial one will do)
/// errors   FileError if it cannot be opened; a damaged end is DecodeReport::error
/// laws     rows never mix cycles, whichever frame is lost (RowsNeverMixCycles); tshark's bytes give the same
/// values (tests/capture) cost     25 to 40 ns a frame; memory does not depend on the length
[[nodiscard]] FileResult<DecodeReport> decode_capture(const std::string& path, const DecodePlan& plan,
                                                      const CaptureSurvey& survey,
                                                      const DecodeOptions& options, const ColumnSink& sink,
                                                      const Progress& progress = {});

}  // namespace abbe
