#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/evaluate/run_table.h"
#include "abbe/fit/drift_record.h"
#include "abbe/fit/function_model.h"
#include "abbe/machine/machine.h"
#include "abbe/machine/read_machine.h"

namespace abbe {

/// Where an instrument looked and how well, common to all kinds of measurements.
struct FitInstrument {
  Vec3 point = Vec3::Zero();  ///< measuring point in the bed frame at home, carried by the tool (or the work)
  bool on_work = false;       ///< the point is fixed to the workpiece instead
  double sign = 1;            ///< -1: the instrument shows the opposite
  std::optional<double> noise;  ///< standard uncertainty of one reading, mm or rad
  double scale_u = 0;           ///< standard uncertainty of the instrument's scale, 1
};

/// Runs of one axis: positioning, straightness or angle.
struct FitRun {
  std::string file;
  std::string name;  ///< of the error, as it is printed
  ErrorName error;
  int axis = 0;
  std::array<double, kMaxAxes> at{};  ///< of the axes that stand still, mm or rad
  FitInstrument instrument;
  std::string square;     ///< straightness: the reference artefact, empty = a straightedge aligned by hand
  bool reversed = false;  ///< the artefact was turned over
  double thermal = 0;     ///< alpha (T - 20): what warm scales add per length; taken off
  RunTable runs;
};

/// Runs along a straight line of several linear axes.
struct FitDiagonal {
  std::string file;
  std::array<double, kMaxAxes> from{}, to{};
  FitInstrument instrument;
  RunTable runs;
};

/// Positions of the measuring point at many poses, seen by a tracker or a measuring machine: in workpiece
/// axes, up to a rigid motion of the whole unless `fixed`. With `ball`: poses at which the tip (a probe) was
/// in the centre of a ball that the workpiece carries.
struct FitPoints {
  std::string file;
  bool fixed = false;
  bool planned = false;  ///< not measured yet: `measured` says nothing
  FitInstrument instrument;
  std::vector<std::array<double, kMaxAxes>> poses;
  std::vector<Vec3> measured;  ///< mm; empty for balls
  std::vector<int> ball;       ///< number of the ball; empty for points
  std::vector<Vec3> readings;  ///< tip - centre of the ball (an R-test), mm; empty: the tip was in the centre
  bool nest_on_work = false;   ///< readings are along axes of the workpiece, not of the tool
};

/// A value known from elsewhere: a squareness of a ball-bar test, of a part that was turned over.
struct FitValue {
  std::string name;
  double value = 0, u = 0;  ///< mm or rad
};

/// A reference square: how much its angle exceeds 90 degrees.
struct FitSquare {
  std::string name;
  double deviation = 0;
  std::optional<double> u;  ///< none: unknown, to be found by turning it over
};

/// How a function is looked for.
struct FitFunction {
  std::string name;
  enum class Form { automatic, polynomial, table, cubic } form = Form::automatic;
  int order = 0;      ///< polynomial
  int count = 0;      ///< table, cubic: values; 0 = one at every target
  double pitch = 0;   ///< mm or deg
  int harmonics = 1;  ///< of the pitch
  enum class Reversal { constant, table, none } reversal = Reversal::constant;
};

/// Everything a fit works on, read and checked.
struct FitJob {
  std::string file;
  Machine machine;  ///< its own errors are not used
  std::vector<FitRun> runs;
  std::vector<FitDiagonal> diagonals;
  std::vector<FitPoints> points;
  std::vector<FitValue> values;
  std::vector<FitSquare> squares;
  std::vector<FitFunction> functions;
  std::vector<std::string> locations;  ///< asked for by name
  FitThermal thermal;
  std::vector<FitDrift> drifts;
  std::array<double, kMaxAxes> reference{};  ///< where functions are zero
  int most_order = 6;
  Calibration calibration;
  std::vector<std::string> files;  ///< everything read

  [[nodiscard]] const FitFunction* find_function(std::string_view name) const;
  [[nodiscard]] const FitSquare* find_square(std::string_view name) const;
};

/// Reads a job (docs/measurement-files.md) with the machine file and the measurements that it names; paths
/// are relative to its folder.
///
/// errors   those of machine files and measurements, and E-JOB-ERROR (no error that the axis has), E-JOB-AXIS
/// (an
///          axis that is not there), E-JOB-KIND (deviations of the wrong quantity), E-JOB-SQUARE (an artefact
///          that is not declared, or whose runs do not span one plane), E-JOB-TWICE (the same file again),
///          E-JOB-EMPTY (nothing measured), E-JOB-RANGE (targets beyond the travel), E-DRIFT-TIME
///          (a log whose time does not increase), E-THERMAL-TEMPERATURE (no temperature of a machine)
/// laws     TotalOnAnyBytes
[[nodiscard]] Parsed<FitJob> read_fit_job(const MachineText& job, const FileFetcher& fetch);

/// How a job is to be measured whose files do not exist yet.
struct MeasurementPlan {
  int targets = 11;
  int runs = 5;
  bool bidirectional = true;
};

/// The same job before it was measured: every run has targets spaced evenly over the travel of its axis
/// (every diagonal over its length, points a grid over all travels, balls where `places` and `angles` say)
/// and readings of 0. Its measurement files are not opened. errors   those of read_fit_job, and E-JOB-RANGE:
/// a travel is not known; E-JOB-BALL: balls that cannot be reached
[[nodiscard]] Parsed<FitJob> plan_fit_job(const MachineText& job, const FileFetcher& fetch,
                                          const MeasurementPlan& plan);

}  // namespace abbe
