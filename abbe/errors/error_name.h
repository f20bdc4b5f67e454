#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace abbe {

/// What an error describes (docs/machine-file.md, ISO 230-1 names plus T, D, t, w).
enum class ErrorClass {
  component,  ///< EXX: of the moving axis, a function of its position
  location,   ///< EC0Y: of the axis line, a constant
  thermal,    ///< TXX: thermal drift
  dynamic,    ///< DXX: of velocity, acceleration, time
};

/// The name of one error component. direction 0..5 = X Y Z (displacement, mm) A B C (rotation
/// about X Y Z, rad). `axis` is a chain element, or "t" (tool) or "w" (workpiece) for mounting errors.
struct ErrorName {
  ErrorClass error_class = ErrorClass::component;
  int direction = 0;
  std::string axis;

  [[nodiscard]] bool is_rotation() const { return direction >= 3; }
  friend bool operator==(const ErrorName&, const ErrorName&) = default;
};

/// Reads EXX, EAZ1, EC0Y, C0Y (short for EC0Y), TZX, DXX, EXt, ECw. The axis is not looked up.
/// nullopt for any other text (also TX0X: thermal and dynamic errors have no `0` form).
[[nodiscard]] std::optional<ErrorName> read_error_name(std::string_view text);

/// The one spelling we print.
[[nodiscard]] std::string to_string(const ErrorName& name);

}  // namespace abbe
