#pragma once

#include <optional>
#include <set>
#include <string>

#include "abbe/cl/verify_statement.h"
#include "abbe/core/linear_algebra.h"

namespace abbe::cl::verifying {

enum class Move { none, from, rapid, feed, hole };

/// A circular piece of path, counted by the right hand about `axis`.
struct Circle {
  Vec3 centre = Vec3::Zero(), axis = Vec3::UnitZ();
  double angle = 0;  ///< rad, > 0, all turns
};

/// One step of a file: a statement, and for motions where the tool goes, in the program's frame (mm).
struct Step {
  Statement statement;
  Move move = Move::none;
  bool opens_circle = false;  ///< CIRCLE, MOVARC
  bool starts_somewhere = false;
  bool axis_stated = false;
  bool rotation_free = false;  ///< the tool axis may differ from the original's
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();
  Vec3 start_axis = Vec3::UnitZ(), end_axis = Vec3::UnitZ();
  std::optional<Circle> circle;
  double up = 0, down = 0;  ///< of a hole, along the tool axis, mm
  std::optional<int> tool;
};

/// What the files do not say; the same as the rewriter was told.
struct Reading {
  std::optional<double> unit;
  bool turn_all = false, turn_none = false;  ///< --tool-axis correct, keep
  int hand = 0;                              ///< +1 right, -1 left, 0 unknown
  std::set<std::string, std::less<>> pass_words;
  bool tool_change_keeps_place = false;
  std::optional<int> tool;
};

/// Follows a CL file for the verification: its own understanding of every statement.
/// errors   a fault (E-...) for what it does not understand: then nothing is verified
class PathReader {
 public:
  PathReader(LineReader reader, std::string name, const Reading& reading)
      : statements_(std::move(reader), std::move(name)), reading_(reading) {
    if (reading.unit) unit_ = *reading.unit;
    tool_ = reading.tool;
  }

  [[nodiscard]] std::optional<Step> next();
  [[nodiscard]] const std::optional<Diagnostic>& fault() const { return fault_; }
  [[nodiscard]] LineReader& file() { return statements_.file(); }
  [[nodiscard]] const std::string& name() const { return statements_.name(); }

 private:
  [[nodiscard]] bool fail(const Statement& at, const char* code, std::string message);
  [[nodiscard]] bool understand(Step& step);
  [[nodiscard]] bool modes(const Statement& s);
  [[nodiscard]] bool frames(const Statement& s);
  [[nodiscard]] bool tools(const Statement& s);
  [[nodiscard]] bool hole_cycle(const Statement& s);
  [[nodiscard]] bool open_circle(Step& step);
  [[nodiscard]] bool motion(Step& step);
  [[nodiscard]] bool close_circle(Step& step);
  [[nodiscard]] Vec3 point(const Statement& s, std::size_t first) const;
  [[nodiscard]] Vec3 direction(const Statement& s, std::size_t first) const;

  StatementReader statements_;
  Reading reading_;
  std::optional<Diagnostic> fault_;
  double unit_ = 0;  ///< mm; 0 = not stated
  Mat3 turn_ = Mat3::Identity(), first_system_ = Mat3::Identity();
  Vec3 moved_ = Vec3::Zero(), added_ = Vec3::Zero(), taken_ = Vec3::Zero(), first_origin_ = Vec3::Zero();
  bool system_known_ = false, world_ = false, over_ = false, clsf_ = false;
  int multax_ = 0;  ///< +1 on, -1 off, 0 never said
  bool rapid_ = false, rapid_ended_ = false, drilling_ = false, circle_open_ = false, place_known_ = false,
       axis_known_ = true;
  double up_ = 0, down_ = 0;
  Vec3 place_ = Vec3::Zero(), axis_ = Vec3::UnitZ();
  Circle circle_;
  double circle_radius_ = 0;
  int turns_ = 1;
  std::optional<int> tool_;
};

}  // namespace abbe::cl::verifying
