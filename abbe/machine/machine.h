#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/core/linear_algebra.h"
#include "abbe/core/units.h"
#include "abbe/errors/error_function.h"
#include "abbe/errors/error_name.h"
#include "abbe/machine/control_model.h"

namespace abbe {

/// More moving axes than this are refused by the reader, so that a pose query is a fixed-size value.
inline constexpr int kMaxAxes = 16;

enum class AxisType { linear, rotary, fixed };
enum class Branch { tool, workpiece };

/// One factor of a body's matrix product (docs/theory/chain.md, table of factors). `inverse` is the
/// minus sign of the machine file ("-location").
enum class FactorKind { motion, location, along, across, thermal, component, dynamic };
struct Factor {
  FactorKind kind = FactorKind::motion;  ///< component is spelled "static" in the file
  bool inverse = false;
  friend bool operator==(const Factor&, const Factor&) = default;
};

/// How location errors act: the orders of docs/machine-file.md.
[[nodiscard]] std::vector<Factor> line_order();
[[nodiscard]] std::vector<Factor> frame_order();
[[nodiscard]] std::vector<Factor> after_order();

/// An element of the chain between workpiece and tool: an axis, or a fixed body with errors.
struct Body {
  std::string name;
  AxisType type = AxisType::linear;
  Branch branch = Branch::tool;
  Vec3 direction = Vec3::UnitX();  ///< unit vector in bed axes: motion of THIS body for an increasing command
  Vec3 origin = Vec3::Zero();      ///< of the body frame, bed frame at home, mm
  std::optional<std::array<double, 2>> range;  ///< travel; mm or rad
  std::vector<Factor> order;
  std::optional<std::string>
      location;  ///< "line", "frame", "after" as given; empty for explicit orders and defaults
  bool errors_seen_at_tool = false;
  bool errors_seen_stated = false;  ///< the file says errors_seen
  std::optional<Vec3> measured_at;  ///< mm, bed frame at home
  std::string address;              ///< word in programs; empty if none
  bool correctable = true;
  int axis = -1;  ///< index among the moving axes; -1 for fixed bodies

  /// It carries the workpiece and nobody says how its errors are seen: they may be of either sign.
  [[nodiscard]] bool errors_have_no_sign() const {
    return branch == Branch::workpiece && !errors_seen_stated;
  }
};

/// True if the body's order lets this error act: some factor carries its class, and for location
/// errors the part of it (along or across) that the order names is not zero.
[[nodiscard]] bool carries(const Body& body, const ErrorName& name);

struct ToolMount {
  Vec3 origin = Vec3::Zero();  ///< gauge point in the bed frame at home, mm
  Vec3 axis = Vec3::UnitZ();   ///< unit vector from the tip to the spindle
  double length = 0;           ///< gauge length, mm; tip = origin - length * axis
};

/// What numbers of the file mean: multiply by these to get mm and rad.
struct FileUnits {
  double length = mm, angle = deg, error_length = um, error_angle = urad;
};

struct Variable {
  enum class Kind { position, velocity, acceleration, sensor };  ///< `t` is a sensor too
  Kind kind = Kind::sensor;
  std::string name;  ///< as in the file: "X", "v.X", "a.X", "T1", "t"
  int axis = -1;     ///< of the moving axes; -1 for sensors
};

/// A sensor that nobody reads: another one through a first-order lag, tau dy/dt + y = u.
struct LaggedSensor {
  std::string name, of;
  double lag = 0;  ///< tau, s, above 0
};

/// Where an error acts.
inline constexpr int kToolBody = -1;
inline constexpr int kWorkpieceBody = -2;

/// One entry of [errors]. Value in mm or rad = scale * function(variables in file units).
struct ErrorTerm {
  ErrorName name;
  int body = 0;  ///< index in Machine::bodies, or kToolBody, kWorkpieceBody
  ErrorFunction function;
  double scale = 1;
  std::optional<ErrorFunction> uncertainty;  ///< standard uncertainty, same scale
  bool of_one_test = false;  ///< scope = "test": not true of the machine, only of the test it came from
};

/// [calibration]: copied into reports and headers.
struct Calibration {
  std::string date, machine_id, control_compensation, valid_to;  ///< dates as YYYY-MM-DD
  std::optional<double> temperature;                             ///< degC
};

/// A machine and its errors, as described by its file: an immutable value.
struct Machine {
  std::string name;
  std::string chain;         ///< as in the file
  std::vector<Body> bodies;  ///< in chain order, from the workpiece to the tool
  std::vector<int> axes;     ///< moving bodies in chain order: axis index -> index in bodies
  ToolMount tool;
  Vec3 workpiece_origin = Vec3::Zero();
  FileUnits units;
  std::vector<Variable> variables;  ///< first one position per moving axis (same index), then the others used
  std::vector<ErrorTerm> errors;    ///< in file order
  std::vector<LaggedSensor> lagged_sensors;  ///< [sensors]
  Calibration calibration;
  ControlModel control;
  std::string sha256;              ///< of machine file, errors file if given apart, and CSV tables
  std::vector<std::string> files;  ///< machine file, errors file, CSV files read

  [[nodiscard]] int axis_count() const { return static_cast<int>(axes.size()); }
  [[nodiscard]] const Body& axis(int i) const {
    return bodies[static_cast<std::size_t>(axes[static_cast<std::size_t>(i)])];
  }
  /// Index of the moving axis with that name, or -1.
  [[nodiscard]] int find_axis(std::string_view axis_name) const;
  /// Position of axis i: internal (mm, rad) = axis_unit(i) * number of the file.
  [[nodiscard]] double axis_unit(int i) const;
  /// True if some error rotates a body, so that the tool's length matters.
  [[nodiscard]] bool has_angular_errors() const;
};

/// The machine as its control leaves it: without the errors that the control corrects itself.
[[nodiscard]] Machine as_controlled(const Machine& machine);

/// The machine as its control believes it to be: without errors, with the control's origins and directions.
[[nodiscard]] Machine as_believed(const Machine& machine);

/// Contract numbering: 0 = bed, then the tool branch from the bed outwards (the tool last), then the
/// workpiece branch from the bed outwards (the workpiece last).
struct BodyNumber {
  int id = 0;
  std::string name;  ///< "b", "t", "w" or the chain element
  int lower = 0;     ///< id of the lower body; 0 for the bed
};
[[nodiscard]] std::vector<BodyNumber> body_numbers(const Machine& machine);

/// Rows L^0, L^1, ... until the first all-zero row, for bodies 1..n (column 0 is body 1). Total: a body
/// that does not lead to the bed ends the array after n + 1 rows.
[[nodiscard]] std::vector<std::vector<int>> lower_body_array(const std::vector<BodyNumber>& bodies);

/// The error names that can act on this chain: six components per moving axis, and those of its six
/// location names that its order carries (zero-position parts included).
[[nodiscard]] std::vector<std::string> error_inventory(const Machine& machine);

/// Names of the errors with scope = "test", in file order. They may be looked at, but no command of the
/// machine may be corrected by them.
[[nodiscard]] std::vector<std::string> errors_of_one_test(const Machine& machine);
/// E-SCOPE if there are such errors: why this machine commands nothing.
[[nodiscard]] std::optional<Diagnostic> refusal_of_one_test(const Machine& machine);

}  // namespace abbe
