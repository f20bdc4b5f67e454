#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/cl/interpreter.h"
#include "abbe/cl/number_edit.h"
#include "abbe/cl/pose_field.h"
#include "abbe/cl/rewrite_cl.h"

namespace abbe::cl {

/// Rewrites one CL file line by line; what rewrite_cl does with its lines.
class Rewriter {
 public:
  Rewriter(const Plan& plan, AxisSet free, const ClJob& job, RewriteReport& report);

  void line(std::string_view bytes, std::uint64_t number, bool too_long, std::string& out);
  void finish(std::string& out);
  [[nodiscard]] Findings& findings() { return findings_; }

 private:
  /// A pose of the path and what is written for it.
  struct Node {
    double s = 0;
    PoseField::Place place;
    ToolPose written;
    Commands q{};      ///< what the post-processor makes of it
    std::string text;  ///< the record that leads to it
  };

  void record(std::string& out);
  void write(std::string_view bytes, std::string& out);
  void check_mark(const Record& record);
  [[nodiscard]] bool use_tool(const Record& record);
  [[nodiscard]] bool motion(const Record& record, std::string& out);
  [[nodiscard]] bool end_node(const Record& record, Node& node);
  [[nodiscard]] bool solve(const Record& record, NumberEdit& edit, const Vec3& from, Node& node);
  void write_axis(const Record& record, NumberEdit& edit, Node& node) const;
  [[nodiscard]] bool place_is_good(const Record& record, const PoseField::Place& place);
  [[nodiscard]] bool refuse(const Record& record, PoseField::Trouble trouble, const ToolPose& pose, int axis);
  [[nodiscard]] bool note(const Record& record, const Node& node);
  [[nodiscard]] bool hole(const Record& record, const Node& node);
  [[nodiscard]] double left_between(const Motion& written, const Node& a, const Node& b) const;
  [[nodiscard]] int samples(const Node& a, const Node& b) const;
  [[nodiscard]] double allowed_in_one() const;
  [[nodiscard]] bool stays_one() const;
  [[nodiscard]] bool may_halve(const Record& record, double left, double part, int depth);

  [[nodiscard]] bool line_pieces(const Record& record, const Node& a, const Node& b, int depth,
                                 std::vector<Node>& ends);
  [[nodiscard]] bool line_motion(const Record& record, const Node& end, std::string& out);
  [[nodiscard]] bool node_between(const Record& record, const Node& a, const Node& b, Node& middle);
  [[nodiscard]] bool too_bent(const Record& record, double left, const char* fix);

  struct ArcPiece {
    Node end;
    Vec3 centre = Vec3::Zero();  ///< to write
  };
  [[nodiscard]] bool arc(const Record& record, const Node& end, std::string& out);
  [[nodiscard]] bool arc_pieces(const Record& record, const Node& a, const Node& b, int depth,
                                std::vector<ArcPiece>& pieces);
  [[nodiscard]] double fit_arc(const Node& a, const Node& b, bool through_middle, Vec3& centre) const;
  void write_arc(const Record& record, const std::vector<ArcPiece>& pieces, std::string& out);
  [[nodiscard]] std::string circle_bytes(const ArcPiece& piece, const Node& start, bool first) const;

  void trace(const Record& record, const Node& end, std::string_view decision, std::string_view written);

  const ClJob& job_;
  RewriteReport& report_;
  const Machine& machine_;
  Findings findings_;
  RecordReader reader_;
  Interpreter interpreter_;
  Placement placement_;
  PoseField field_;
  Digits digits_;
  std::vector<Record> held_;  ///< a circle and what stands before its GOTO
  std::optional<int> tool_;
  bool tool_used_ = false, header_written_ = false, singular_warned_ = false;
  std::optional<Node> last_;  ///< the end of the motion before
  Vec3 correction_ = Vec3::Zero();
};

}  // namespace abbe::cl
