#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "abbe/cl/interpreter.h"
#include "abbe/core/number.h"

namespace abbe::cl {
namespace {

constexpr double kOrthonormal = 1e-4;  // what six printed digits leave of a rotation
constexpr double kUnitLength = 1e-3;   // what three printed digits leave of a unit vector

bool all_numbers(const Record& record, std::size_t count) {
  return record.items.size() == count && record.leading_numbers() == count;
}

Vec3 numbers_at(const Record& record, std::size_t first) {
  return {record.items[first].value, record.items[first + 1].value, record.items[first + 2].value};
}

bool is_rotation(const Mat3& matrix) {
  return (matrix * matrix.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() < kOrthonormal &&
         matrix.determinant() > 0;
}

}  // namespace

// program = R_rel (unit x) + o_rel + TRANS - ORIGIN
void Interpreter::refresh_frame() {
  frame_.rotation = relative_rotation_;
  frame_.origin = relative_origin_ + trans_ - origin_;
}

bool Interpreter::frame_record(const Record& record, Findings& findings) {
  if (record.major == "TRNTYP") {
    // Coordinates of the world: CSYS behind it names a plane, and does not move the numbers.
    world_ = record.items.size() == 4 && record.items[0].word == "WORLD" && record.items[1].is_number &&
             record.items[1].value == 0 && record.items[2].is_number && record.items[2].value == 0 &&
             record.items[3].is_number && record.items[3].value == 0;
    if (world_) return true;
    findings.refuse(
        record, {"E-FRAME", "coordinates in another frame than TRNTYP/WORLD,0,0,0",
                 "what the numbers are measured from is not known", "write the file in world coordinates"});
    return false;
  }
  if (!has_unit(record, findings)) return false;
  if (record.major == "MSYS") return msys(record, findings);
  if (record.major == "CSYS") return csys(record, findings);
  return shift(record, findings);
}

/// TRANS/x,y,z adds to the coordinates; ORIGIN/x,y,z is where the machine's zero stands among them.
bool Interpreter::shift(const Record& record, Findings& findings) {
  if (!all_numbers(record, 3)) {
    findings.refuse(record, {"E-FRAME", fmt::format("{} is not followed by three numbers", record.major),
                             "scales, rotations and their like are made by the post-processor",
                             "write literal shifts: TRANS/x,y,z"});
    return false;
  }
  (record.major == "TRANS" ? trans_ : origin_) = frame_.unit * numbers_at(record, 0);
  refresh_frame();
  return true;
}

/// The coordinate system of a tool path. The first one is the frame of the program; others stand to it as
/// they do in the CAM system.
bool Interpreter::msys(const Record& record, Findings& findings) {
  Mat3 rotation;
  if (all_numbers(record, 9)) {
    rotation.col(0) = numbers_at(record, 3);
    rotation.col(1) = numbers_at(record, 6);
    rotation.col(2) = rotation.col(0).cross(rotation.col(1));
  }
  if (!all_numbers(record, 9) || !is_rotation(rotation)) {
    findings.refuse(record, {"E-FRAME", "MSYS is not an origin and two axes at right angles",
                             "where the coordinates are measured from is not known",
                             "write MSYS/x,y,z,xi,xj,xk,yi,yj,yk"});
    return false;
  }
  const Vec3 origin = frame_.unit * numbers_at(record, 0);
  if (!msys_seen_) {
    msys_seen_ = true;
    msys_rotation_ = rotation;
    msys_origin_ = origin;
    return true;
  }
  const Mat3 relative = msys_rotation_.transpose() * rotation;
  const Vec3 shift = msys_rotation_.transpose() * (origin - msys_origin_);
  if (relative != relative_rotation_ || shift != relative_origin_) {
    findings.warn(record, {"W-FRAME", "another MSYS than that of the first tool path",
                           "it is taken to stand to the first as it does in the CAM system",
                           "if it is another set-up, split the file there and give each part its --offset"});
    relative_rotation_ = relative;
    relative_origin_ = shift;
    at_known_ = false;
    at_.axis = relative.col(2).normalized();
    forget_axis();
    refresh_frame();
  }
  return true;
}

/// Rows of [R | t]: column 3 of R is the tool axis of what follows. Coordinates stay those of the world.
bool Interpreter::csys(const Record& record, Findings& findings) {
  Mat3 rotation;
  if (all_numbers(record, 12)) {
    for (std::size_t row = 0; row < 3; ++row)
      rotation.row(static_cast<Eigen::Index>(row)) = numbers_at(record, 4 * row).transpose();
  }
  if (!all_numbers(record, 12) || !is_rotation(rotation)) {
    findings.refuse(record, {"E-FRAME", "CSYS is not a rotation and a shift of twelve numbers",
                             "which plane the operation works in is not known", "write the file again"});
    return false;
  }
  if (!world_ && rotation != Mat3(Mat3::Identity())) {
    findings.refuse(record, {"E-FRAME", "a turned or shifted CSYS without TRNTYP/WORLD before it",
                             "whether the coordinates are those of the world or of the plane is not known",
                             "write the file in world coordinates (TRNTYP/WORLD,0,0,0)"});
    return false;
  }
  // A turned plane states its tool axis in its own records; a level one need not.
  at_.axis = rotation.col(2).normalized();
  if ((at_.axis - Vec3::UnitZ()).norm() < kOrthonormal) at_.axis = Vec3::UnitZ();
  forget_axis();
  return true;
}

bool Interpreter::tool_axis_record(const Record& record, Findings& findings) {
  const bool good = all_numbers(record, 3) && std::abs(numbers_at(record, 0).norm() - 1) < kUnitLength;
  if (!good) {
    findings.refuse(record, {"E-TLAXIS", "TLAXIS is not followed by a unit vector",
                             "the tool axis of what follows is not known", "write TLAXIS/i,j,k"});
    return false;
  }
  at_.axis = (frame_.rotation * numbers_at(record, 0)).normalized();
  axis_sure_ = true;
  return true;
}

/// `$$*CATIA0` and the axis system in the remarks behind it: one is the frame of the program, a second one is
/// refused, because writers differ on the rows and columns of a turned one.
bool Interpreter::remark(const Record& record, Findings& findings) {
  const std::string_view text = record.text;
  if (text.starts_with("*CATIA0")) {
    catia_numbers_ = 0;
    catia_matrix_.clear();
    return true;
  }
  if (catia_numbers_ < 0) return true;
  int count = 0;
  std::string numbers;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n", at);
    if (begin == std::string_view::npos) break;
    at = std::min(text.find_first_of(" \t\r\n", begin), text.size());
    const auto value = read_number(text.substr(begin, at - begin));
    if (!value) return true;  // a name between the mark and the numbers
    numbers += to_shortest(*value) + ' ';
    ++count;
  }
  if (count != 4) return true;
  catia_matrix_ += numbers;
  if ((catia_numbers_ += count) < 12) return true;
  catia_numbers_ = -1;
  if (catia_first_.empty()) catia_first_ = catia_matrix_;
  if (catia_first_ == catia_matrix_) return true;
  findings.refuse(record, {"E-FRAME", "a second axis system ($$*CATIA0) that differs from the first",
                           "how it stands to the part on the machine is not known",
                           "write one file for each axis system"});
  return false;
}

}  // namespace abbe::cl
