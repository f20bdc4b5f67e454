#include "tests/oracle/follow.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace abbe::oracle {
namespace {

// Parameter of the point of path(t), t in [0, 1], next to x: Gauss-Newton from a guess.
template <class Path>
double nearest(const Path& path, const Vec3& x, double guess) {
  double t = std::clamp(guess, 0.0, 1.0);
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-6;
    const double a = std::max(0.0, t - kStep), b = std::min(1.0, t + kStep);
    const Vec3 slope = (path(b) - path(a)) / (b - a);
    if (slope.squaredNorm() == 0) break;
    t = std::clamp(t + slope.dot(x - path(t)) / slope.squaredNorm(), 0.0, 1.0);
  }
  return t;
}

double length_of(const Motion& motion) {
  constexpr int kChords = 16;
  double length = 0;
  for (int k = 0; k < kChords; ++k) {
    length +=
        (point_at(motion, (k + 1.0) / kChords) - point_at(motion, static_cast<double>(k) / kChords)).norm();
  }
  return length;
}

std::string place(const Motion& original, const Motion& rewritten, const std::string& what) {
  std::ostringstream text;
  text.precision(9);
  text << what << ": line " << original.line << " to " << original.end.transpose() << ", rewritten line "
       << rewritten.line << " to " << rewritten.end.transpose();
  return text.str();
}

}  // namespace

Following follow(const std::vector<Motion>& original, const std::vector<Motion>& rewritten,
                 const Tip& nominal, const Tip& actual, double allowed) {
  Following result;
  std::size_t next = 0;
  bool on_path = false;
  for (const Motion& motion : original) {
    if (!on_path) ++result.before;
    const Vec3 goal = nominal(motion.end, motion.tool);
    const double length = length_of(motion);
    const auto path = [&](double t) { return nominal(point_at(motion, t), motion.tool); };
    double done = 0;   // how far along the original
    double start = 0;  // distance of the start from the path, if it is not on it
    if (next < rewritten.size()) {
      start = (actual(rewritten[next].start, rewritten[next].tool) - path(0)).norm();
      if (start <= allowed) start = 0;
    }
    for (bool arrived = false; !arrived;) {
      if (next == rewritten.size()) {
        result.fault = "the rewritten program ends before line " + std::to_string(motion.line);
        return result;
      }
      const Motion& piece = rewritten[next++];
      const bool rapid = motion.kind == Motion::Kind::rapid;
      // Cycles leave out rapids of no length; a correction may give them one, or take it.
      if (!rapid && piece.kind == Motion::Kind::rapid &&
          (actual(piece.end, piece.tool) - path(0)).norm() <= allowed)
        continue;
      if (rapid && piece.kind != Motion::Kind::rapid && length == 0) {
        --next;
        break;
      }
      if (rapid != (piece.kind == Motion::Kind::rapid)) {
        result.fault = place(motion, piece, "a rapid answers a feed or the reverse");
        return result;
      }
      const double miss = (actual(piece.end, piece.tool) - goal).norm();
      if (miss <= allowed) on_path = true;
      if (rapid && !on_path) break;
      if (rapid) {
        result.worst_rapid = std::max(result.worst_rapid, miss);
        if (!(miss <= allowed)) {
          result.fault = place(motion, piece, "a rapid misses by " + std::to_string(miss * 1e3) + " um");
          return result;
        }
        break;
      }
      constexpr int kSamples = 8;
      const double piece_share = length > 0 ? length_of(piece) / length : 1;
      const double before = done;
      for (int k = 1; k <= kSamples; ++k) {
        const double s = static_cast<double>(k) / kSamples;
        const Vec3 x = actual(point_at(piece, s), piece.tool);
        done = nearest(path, x, before + s * piece_share);
        const double distance = (x - path(done)).norm();
        if (start == 0) result.worst_feed = std::max(result.worst_feed, distance);
        if (!(distance <= allowed + (1 - done) * start)) {
          result.fault =
              place(motion, piece, "a feed leaves the path by " + std::to_string(distance * 1e3) + " um");
          return result;
        }
      }
      // Short of the end by less than the tolerance is there; a full circle passes its end point at the
      // start, too.
      arrived = miss <= allowed && (1 - done) * length <= std::max(2 * allowed, 1e-6 * length);
    }
  }
  if (next != rewritten.size()) {
    result.fault = "the rewritten program goes on at line " + std::to_string(rewritten[next].line);
  }
  return result;
}

}  // namespace abbe::oracle
