#include "tests/oracle/interpreter.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

namespace abbe::oracle {
namespace {

std::string quoted(const std::string& path) {
  std::string text = "'";
  for (const char c : path) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// LinuxCNC's CANON_PLANE: 1 = XY, 2 = YZ, 3 = XZ.
Vec3 normal_of(int plane) {
  if (plane == 1) return Vec3::UnitZ();
  return plane == 2 ? Vec3::UnitX() : Vec3::UnitY();
}

std::vector<Motion> read_motions(const std::string& path) {
  std::vector<Motion> motions;
  std::ifstream file(path);
  Vec3 at = Vec3::Zero();
  double rotation = 0;  // of the work offset in force, about Z
  int tool = -1;
  for (std::string text; std::getline(file, text);) {
    std::istringstream line(text);
    Motion motion;
    std::string kind;
    line >> motion.line >> kind;
    if (kind == "ROT") {
      line >> rotation;
      rotation *= std::numbers::pi / 180;
      continue;
    }
    if (kind == "TOOL") line >> tool;
    if (kind != "R" && kind != "F" && kind != "ARC") continue;
    motion.kind = kind == "R" ? Motion::Kind::rapid : kind == "F" ? Motion::Kind::feed : Motion::Kind::arc;
    if (kind == "ARC") {
      int plane = 1;
      line >> plane >> motion.turns;
      motion.normal = Eigen::AngleAxisd(rotation, Vec3::UnitZ()) * normal_of(plane);
    }
    std::array<double, 3> rotary{};
    line >> motion.end.x() >> motion.end.y() >> motion.end.z() >> rotary[0] >> rotary[1] >> rotary[2];
    if (kind == "ARC") line >> motion.centre.x() >> motion.centre.y() >> motion.centre.z();
    motion.start = at;
    motion.tool = tool;
    at = motion.end;
    motions.push_back(motion);
  }
  return motions;
}

}  // namespace

Vec3 point_at(const Motion& motion, double s) {
  if (motion.kind != Motion::Kind::arc) return motion.start + s * (motion.end - motion.start);
  const Vec3& n = motion.normal;
  const Vec3 from = motion.start - motion.centre, to = motion.end - motion.centre;
  const double height_start = from.dot(n), height_end = to.dot(n);
  const Vec3 a = from - height_start * n, b = to - height_end * n;
  double angle = std::atan2(n.dot(a.cross(b)), a.dot(b));
  constexpr double kTurn = 2 * std::numbers::pi;
  constexpr double kSame = 1e-6;  // an end this close behind the start is a full turn
  if (motion.turns > 0) {
    while (angle <= kSame) angle += kTurn;
    angle += kTurn * (motion.turns - 1);
  } else {
    while (angle >= -kSame) angle -= kTurn;
    angle += kTurn * (motion.turns + 1);
  }
  const double radius = a.norm() + s * (b.norm() - a.norm());
  const Vec3 direction = Eigen::AngleAxisd(s * angle, n) * a.normalized();
  return motion.centre + radius * direction + (height_start + s * (height_end - height_start)) * n;
}

std::optional<Run> run(const std::string& oracle, const std::string& tool_table, const std::string& program,
                       const std::string& scratch) {
  std::filesystem::create_directories(scratch);
  const std::string canon = scratch + "/canon.txt", said = scratch + "/said.txt";
  std::filesystem::remove(canon);
  std::ofstream(scratch + "/parameters.var").close();  // empty: all work offsets 0
  const std::string command = "cd " + quoted(scratch) + " && " + quoted(oracle) +
                              " -m -v parameters.var -t " + quoted(tool_table) + " -o " + quoted(canon) +
                              " " + quoted(program) + " 2> " + quoted(said);
  const int status = std::system(command.c_str());  // NOLINT(cert-env33-c,bugprone-command-processor)
  if (!std::filesystem::exists(canon)) return std::nullopt;
  Run run;
  run.accepted = status == 0;
  run.message = text_of(said);
  run.open_end = !run.accepted &&
                 run.message.find("File ended with no percent sign or program end") != std::string::npos;
  run.motions = read_motions(canon);
  return run;
}

}  // namespace abbe::oracle
