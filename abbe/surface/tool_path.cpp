#include "abbe/surface/tool_path.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace abbe {
namespace {

constexpr std::size_t kStations = 48;  // per knot span along a pass, at most kMostStations in all
constexpr std::size_t kMostStations = 400;
constexpr std::size_t kScan = 8;    // samples per knot span and direction
constexpr double kSteep = 0.02;     // least n.z a tool along z can reach
constexpr double kGouge = 1e-6;     // mm
constexpr double kRight = 1e-13;    // of scallop or step: all platforms write the same digits
constexpr double kLeftOver = 1e-3;  // of a step
constexpr int kDeepest = 14;        // halvings between two stations

Vec3 centre_of(const ToolContact& contact, double radius) {
  return contact.contact + radius * contact.normal;
}

/// Distance of a point from the line through two others.
double off_chord(const Vec3& point, const Vec3& from, const Vec3& to) {
  const Vec3 chord = to - from, off = point - from;
  const double square = chord.squaredNorm();
  return square > 0 ? (off - off.dot(chord) / square * chord).norm() : off.norm();
}

/// Lays the passes over the parameters: `a` from pass to pass, `b` along a pass.
class Planner {
 public:
  Planner(const NearestPoint& nominal, const ToolPathJob& job, const Progress& progress)
      : nominal_(nominal), surface_(nominal.surface()), job_(job), progress_(progress) {
    const std::size_t along = job.along_v ? 1 : 0;
    range_ = surface_.range(1 - along);
    b_ = span_samples(surface_, along, kStations);
    if (b_.size() > kMostStations) b_ = span_samples(surface_, along, 4);
  }

  std::variant<ToolPath, ToolPathFault> run() {
    scan();
    std::vector<double> a(b_.size(), range_[0]);
    if (!fault_) emit(a, {});
    while (!fault_ && *std::min_element(a.begin(), a.end()) < range_[1]) {
      const std::vector<double> before = a;
      advance(a);
      if (!fault_) emit(a, before);
      if (path_.passes.size() > kMostPasses || path_.points > kMostPathPoints)
        fail(ToolPathFault::Kind::endless, at(a[0], b_[0]), 0);
      const double way = (a[0] - range_[0]) / (range_[1] - range_[0]);
      if (progress_ && !progress_(static_cast<std::uint64_t>(1e4 * way), 10000))
        fail(ToolPathFault::Kind::stopped, at(a[0], b_[0]), 0);
    }
    if (fault_) return *fault_;
    return std::move(path_);
  }

 private:
  /// The narrowest hollow of all is worth more to the user than the first contact that fails.
  void scan() {
    double narrowest = 1;
    SurfacePlace where;
    for (const double u : span_samples(surface_, 0, kScan))
      for (const double v : span_samples(surface_, 1, kScan)) {
        const double share = curvature_at(evaluate(surface_, {u, v})).most * job_.radius;
        if (share >= narrowest) narrowest = share, where = {u, v};
      }
    if (narrowest > 1)
      fail(ToolPathFault::Kind::curvature, evaluate(surface_, where), job_.radius / narrowest, where);
  }

  [[nodiscard]] SurfacePlace place(double a, double b) const {
    return job_.along_v ? SurfacePlace{a, b} : SurfacePlace{b, a};
  }
  [[nodiscard]] SurfacePoint at(double a, double b) const { return evaluate(surface_, place(a, b)); }

  void fail(ToolPathFault::Kind kind, const SurfacePoint& s, double value, SurfacePlace where = {}) {
    if (!fault_) fault_ = ToolPathFault{kind, where, s.p, value};
  }

  [[nodiscard]] ToolContact contact(double a, double b) {
    const SurfacePlace where = place(a, b);
    const SurfacePoint s = evaluate(surface_, where);
    ToolContact out{where, s.p, s.normal, s.p + job_.radius * (s.normal - Vec3::UnitZ())};
    const double bend = curvature_at(s).most;
    if (s.is_pole() || !s.is_regular()) fail(ToolPathFault::Kind::pole, s, 0, where);
    if (!(s.normal.z() > kSteep)) fail(ToolPathFault::Kind::undercut, s, s.normal.z(), where);
    if (bend * job_.radius >= 1) fail(ToolPathFault::Kind::curvature, s, 1 / bend, where);
    if (fault_) return out;
    // The ball touches here; nowhere may the surface be nearer to its centre than R.
    const double depth = job_.radius - nominal_(centre_of(out, job_.radius)).distance;
    if (depth > kGouge) fail(ToolPathFault::Kind::gouge, s, depth, where);
    return out;
  }

  /// Scallop or step between a and a + da at station b, of what is wanted: 1 is right.
  [[nodiscard]] double share(double a, double da, double b, const Vec3& tangent) const {
    const SurfacePoint from = at(a, b), to = at(a + da, b);
    const auto across = [&](const Vec3& way) { return (way - way.dot(tangent) * tangent).norm(); };
    if (job_.scallop <= 0) return across(to.p - from.p) / job_.step;
    const SurfacePoint middle = at(a + da / 2, b);
    const Vec3 c0 = from.p + job_.radius * from.normal, c1 = to.p + job_.radius * to.normal;
    const double half = across(c1 - c0) / 2, below = job_.radius * job_.radius - half * half;
    if (below <= 0) return 1e6;
    // h = ((c0 + c1) / 2 - n sqrt(R^2 - d^2 / 4) - S) . n
    const double h = ((c0 + c1) / 2 - middle.p).dot(middle.normal) - std::sqrt(below);
    return std::sqrt(std::max(h, 0.0) / job_.scallop);
  }

  /// A first da: the step for the curvature here, over how fast the surface moves across the pass.
  [[nodiscard]] double guess(const SurfacePoint& s, const Vec3& tangent) const {
    const Vec3 across = s.normal.cross(tangent);
    const double speed = std::abs((job_.along_v ? s.u : s.v).dot(across));
    const double step = job_.scallop > 0
                            ? step_for_scallop(job_.radius, job_.scallop, curvature_along(s, across))
                            : job_.step;
    return speed > 0 ? step / speed : 0;
  }

  /// The next pass.
  void advance(std::vector<double>& a) {
    const double whole = range_[1] - range_[0];
    std::vector<double> next = a;
    for (std::size_t j = 0; j < a.size() && !fault_; ++j) {
      if (a[j] >= range_[1]) continue;
      const std::size_t left = j > 0 ? j - 1 : j, right = std::min(j + 1, a.size() - 1);
      const Vec3 tangent = (at(a[right], b_[right]).p - at(a[left], b_[left]).p).normalized();
      double da = std::clamp(guess(at(a[j], b_[j]), tangent), whole * 1e-6, whole);
      for (int i = 0; i < 12; ++i) {
        const double is = share(a[j], da, b_[j], tangent);
        if (a[j] + da >= range_[1] && is <= 1) break;  // the rim is near enough
        if (std::abs(is - 1) < kRight) break;
        da = std::min(da * std::clamp(1 / std::max(is, 1e-9), 0.2, 5.0), whole);
      }
      // What is left of a step at the rim would be a pass of its own.
      next[j] = a[j] + (1 + kLeftOver) * da >= range_[1] ? range_[1] : a[j] + da;
      if (next[j] - a[j] < whole / static_cast<double>(kMostPasses) && next[j] < range_[1])
        fail(ToolPathFault::Kind::endless, at(a[j], b_[j]), 0, place(a[j], b_[j]));
    }
    for (std::size_t j = 0; j < a.size(); ++j)
      if (next[j] > a[j]) measure((at(next[j], b_[j]).p - at(a[j], b_[j]).p).norm(), next[j] >= range_[1]);
    a = std::move(next);
  }

  void measure(double step, bool last) {
    path_.most_step = std::max(path_.most_step, step);
    if (!last) path_.least_step = path_.least_step == 0 ? step : std::min(path_.least_step, step);
  }

  /// Points of a line in the parameters, from the first (already put) to the second, until chords are good
  /// enough.
  void line(ToolPass& pass, std::array<double, 2> from, std::array<double, 2> to, int depth) {
    if (fault_) return;
    const ToolContact first = pass.points.back(), last = contact(to[0], to[1]);
    const std::array<double, 2> middle{(from[0] + to[0]) / 2, (from[1] + to[1]) / 2};
    const double sag = off_chord(tip_at(middle[0], middle[1]), first.tip, last.tip);
    if (depth > 0 && sag > job_.tolerance) {
      line(pass, from, middle, depth - 1);
      line(pass, middle, to, depth - 1);
      return;
    }
    put(pass, last);
  }

  [[nodiscard]] Vec3 tip_at(double a, double b) const {
    const SurfacePoint s = at(a, b);
    return s.p + job_.radius * (s.normal - Vec3::UnitZ());
  }

  /// Stations first to last of a run (the first is already put): one chord where it passes all between, else
  /// halves.
  void along(ToolPass& pass, const std::vector<double>& a, const std::vector<std::size_t>& run,
             std::size_t first, std::size_t last) {
    if (fault_ || first == last) return;
    const std::size_t j0 = run[first], j1 = run[last];
    if (last == first + 1) {
      line(pass, {a[j0], b_[j0]}, {a[j1], b_[j1]}, kDeepest);
      return;
    }
    const Vec3 from = tip_at(a[j0], b_[j0]), to = tip_at(a[j1], b_[j1]);
    bool near = true;
    for (std::size_t k = first + 1; k < last && near; ++k)
      near = off_chord(tip_at(a[run[k]], b_[run[k]]), from, to) <= job_.tolerance;
    if (near) {
      put(pass, contact(a[j1], b_[j1]));
      return;
    }
    const std::size_t middle = (first + last) / 2;
    along(pass, a, run, first, middle);
    along(pass, a, run, middle, last);
  }

  /// Over a crease the ball jumps from one side to the other, and the chord between would cut the crease off.
  void check_chord(const ToolContact& a, const ToolContact& b) {
    // Normals w apart: in the middle of the chord the ball may be R (1 - cos(w / 2)) = R (1 - |n_a + n_b| /
    // 2) deep. On a smooth surface less than the tolerance, so the nearest point is seldom asked.
    if (fault_ || job_.radius * (1 - (a.normal + b.normal).norm() / 2) <= job_.tolerance) return;
    const Vec3 middle = (centre_of(a, job_.radius) + centre_of(b, job_.radius)) / 2;
    const SurfaceFoot foot = nominal_(middle);
    const double depth = job_.radius - foot.distance;
    if (depth > job_.tolerance) fail(ToolPathFault::Kind::gouge, foot.at, depth, foot.place);
  }

  void put(ToolPass& pass, const ToolContact& point) {
    if (!pass.points.empty()) {
      check_chord(pass.points.back(), point);
      path_.length += (point.tip - pass.points.back().tip).norm();
    }
    pass.points.push_back(point);
    ++path_.points;
  }

  /// Runs of stations that moved since the pass before, as polylines; every other pass backwards.
  void emit(const std::vector<double>& a, const std::vector<double>& before) {
    const auto lives = [&](std::size_t j) { return before.empty() || before[j] < range_[1]; };
    const bool back = job_.zigzag && passes_++ % 2 == 1;
    const std::size_t n = a.size();
    const auto station = [&](std::size_t k) { return back ? n - 1 - k : k; };
    for (std::size_t k = 0; k < n && !fault_;) {
      if (!lives(station(k))) {
        ++k;
        continue;
      }
      ToolPass pass;
      const std::size_t first = k;
      std::size_t j = station(k);
      start(pass, a[j], b_[j], job_.zigzag && first == 0);
      std::vector<std::size_t> run{j};
      for (++k; k < n && lives(station(k)); ++k) run.push_back(station(k));
      along(pass, a, run, 0, run.size() - 1);
      j = run.back();
      end_ = {a[j], b_[j]};
      path_.passes.push_back(std::move(pass));
    }
  }

  /// Begins a pass: where the one before ended at the same station, along the rim from there.
  void start(ToolPass& pass, double a, double b, bool may_link) {
    if (may_link && !path_.passes.empty() && end_[1] == b) {
      pass.linked = true;
      pass.points.push_back(path_.passes.back().points.back());
      line(pass, end_, {a, b}, kDeepest);
      pass.points.erase(pass.points.begin());
    } else {
      put(pass, contact(a, b));
    }
  }

  const NearestPoint& nominal_;
  const NurbsSurface& surface_;
  const ToolPathJob& job_;
  const Progress& progress_;
  std::array<double, 2> range_{};
  std::vector<double> b_;
  std::array<double, 2> end_{};  ///< a, b at the end of the last pass
  std::size_t passes_ = 0;
  std::optional<ToolPathFault> fault_;
  ToolPath path_;
};

}  // namespace

std::variant<ToolPath, ToolPathFault> make_tool_path(const NearestPoint& nominal, const ToolPathJob& job,
                                                     const Progress& progress) {
  return Planner(nominal, job, progress).run();
}

double step_for_scallop(double radius, double scallop, double curvature) {
  if (!(scallop > 0) || scallop >= radius || curvature * radius >= 1) return 0;
  if (std::abs(curvature) < 1e-9) return 2 * std::sqrt(scallop * (2 * radius - scallop));
  // |q| for the circle of contacts; centres at q - R in a hollow, q + R about a hump; the cusp at q -+ h
  const double q = 1 / std::abs(curvature), sign = curvature > 0 ? -1 : 1;
  const double centres = q + sign * radius, cusp = q + sign * scallop;
  const double cosine = (centres * centres + cusp * cusp - radius * radius) / (2 * centres * cusp);
  return std::abs(cosine) <= 1 ? 2 * q * std::sin(std::acos(cosine)) : 0;
}

std::string to_text(const ToolPathFault& fault) {
  const std::string at =
      fmt::format("at x {:.3f}, y {:.3f}, z {:.3f}", fault.point.x(), fault.point.y(), fault.point.z());
  switch (fault.kind) {
    case ToolPathFault::Kind::curvature:
      return fmt::format("the surface is hollow with a radius of {:.3f} mm {}", fault.value, at);
    case ToolPathFault::Kind::pole:
      return fmt::format("the lines of the surface meet in one point, a pole, {}", at);
    case ToolPathFault::Kind::undercut:
      return fmt::format("a tool along z cannot touch the surface {} (n.z = {:.3f})", at, fault.value);
    case ToolPathFault::Kind::gouge:
      return fmt::format("the ball cuts {:.4f} mm into the surface or a crease of it {}", fault.value, at);
    case ToolPathFault::Kind::endless:
      return fmt::format("too many passes or points, {}", at);
    case ToolPathFault::Kind::stopped:
      break;
  }
  return "stopped";
}

}  // namespace abbe
