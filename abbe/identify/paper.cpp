#include "abbe/identify/paper.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <variant>

#include "abbe/core/least_squares.h"
#include "abbe/signal/sine_fit.h"

namespace abbe {
namespace {

using Origin = PaperCoefficient::Origin;

constexpr double kRankTolerance = 1e-9;  // exact circles leave a gap from 1e-7 to 1e-16
constexpr double kDetermined = 1 - 1e-6;
constexpr std::size_t kCoefficients = 72;

/// dynamic, direction, axis, first or second coefficient -> place among the 72.
std::size_t index_of(bool dynamic, int direction, int axis, int which) {
  return static_cast<std::size_t>(((dynamic ? 6 : 0) + direction) * 6 + axis * 2 + which);
}

std::vector<PaperCoefficient> all_coefficients() {
  std::vector<PaperCoefficient> out(kCoefficients);
  for (const bool dynamic : {false, true}) {
    for (int direction = 0; direction < 6; ++direction) {
      for (int axis = 0; axis < 3; ++axis) {
        for (int which = 0; which < 2; ++which) {
          PaperCoefficient& c = out[index_of(dynamic, direction, axis, which)];
          c.dynamic = dynamic;
          c.direction = direction;
          c.axis = axis;
          c.order = !dynamic && direction == axis ? which : which + 1;
        }
      }
    }
  }
  return out;
}

/// The deviation at sample i of a test is linear in the coefficients:
///
///   D = sum over both axes (delta + xi) + (theta + eps)_first x (r e_first + q e_second)
///                                        + (theta + eps)_second x (r e_first)
class DesignRow {
 public:
  DesignRow(const PaperTest& test, std::size_t i) : plane_(test.plane) {
    for (std::size_t k = 0; k < 2; ++k) {
      q_[k] = test.displacement[k][i];
      sine_[k] = {std::sin(test.velocity[k].omega * test.time[i] + test.velocity[k].phase),
                  std::sin(test.acceleration[k].omega * test.time[i] + test.acceleration[k].phase)};
    }
    lever_[0] = test.radius * Vec3::Unit(plane_.first) + q_[1] * Vec3::Unit(plane_.second);
    lever_[1] = test.radius * Vec3::Unit(plane_.first);
  }

  /// Factor of a coefficient in the component of D along `component`.
  [[nodiscard]] double operator()(const PaperCoefficient& c, int component) const {
    if (c.axis != plane_.first && c.axis != plane_.second) return 0;
    const std::size_t k = c.axis == plane_.first ? 0 : 1;
    const double lever = c.direction < 3 ? (c.direction == component ? 1.0 : 0.0)
                                         : Vec3::Unit(c.direction - 3).cross(lever_[k])[component];
    if (lever == 0) return 0;
    if (c.dynamic) return lever * sine_[k][static_cast<std::size_t>(c.order - 1)];
    return lever * (c.order == 0 ? 1 : c.order == 1 ? q_[k] : q_[k] * q_[k]);
  }

 private:
  TestPlane plane_;
  std::array<double, 2> q_{};
  std::array<std::array<double, 2>, 2> sine_{};
  std::array<Vec3, 2> lever_;
};

/// True if the element acts on that component of the deviation in that plane at all.
bool acts(const PaperCoefficient& c, TestPlane plane, int component) {
  if (c.axis != plane.first && c.axis != plane.second) return false;
  if (c.direction < 3) return c.direction == component;
  const Vec3 rotation = Vec3::Unit(c.direction - 3);
  return rotation.cross(Vec3::Unit(plane.first))[component] != 0 ||
         (c.axis == plane.first && rotation.cross(Vec3::Unit(plane.second))[component] != 0);
}

/// One least squares of the sequence.
class Step {
 public:
  Step(PaperResult& result, std::string equation) : result_(result) { step_.equation = std::move(equation); }

  /// Chooses the unknowns: those without a value that `wanted` names.
  template <class Wanted>
  void choose(Wanted wanted) {
    for (std::size_t i = 0; i < kCoefficients; ++i) {
      const PaperCoefficient& c = result_.coefficients[i];
      if (c.origin == Origin::missing && wanted(c)) unknown_.push_back(i);
    }
    factor_.emplace(static_cast<Eigen::Index>(unknown_.size()));
  }

  /// A row: `value` less what the known coefficients that `in_row` names make of it.
  template <class InRow>
  void add(const DesignRow& row, int component, double value, InRow in_row) {
    std::vector<double> factors;
    for (const std::size_t i : unknown_) factors.push_back(row(result_.coefficients[i], component));
    for (const PaperCoefficient& c : result_.coefficients)
      if (c.origin != Origin::missing && in_row(c)) value -= c.value * row(c, component);
    factor_->add(factors, value);
  }

  void solve_for(Origin origin, int test) {
    const LeastSquaresSolution fit = solve(*factor_, {kRankTolerance, true});
    result_.finite = result_.finite && fit.ok();
    // The unscaled columns differ by 1e7, which would cost as many digits of the null space: solve with
    // scaled columns, then take the least norm of the unscaled unknowns,  x <- x - N N^+ x.
    Eigen::VectorXd x = fit.x;
    if (fit.null_space.cols() > 0 && fit.null_space.rows() > 0)
      x -= fit.null_space * fit.null_space.colPivHouseholderQr().solve(fit.x);
    result_.finite = result_.finite && x.allFinite();
    step_.rank = fit.rank;
    step_.unknowns = x.size();
    if (fit.rows > 0) step_.rms_residual = std::sqrt(fit.sum_of_squares / static_cast<double>(fit.rows));
    for (std::size_t k = 0; k < unknown_.size(); ++k) {
      PaperCoefficient& c = result_.coefficients[unknown_[k]];
      const auto i = static_cast<Eigen::Index>(k);
      c.value = x[i];
      c.test = test;
      c.origin = origin == Origin::measured && fit.determined[i] < kDetermined ? Origin::artefact : origin;
    }
    result_.steps.push_back(step_);
  }

 private:
  PaperResult& result_;
  PaperStep step_;
  std::vector<std::size_t> unknown_;
  std::optional<TriangularFactor> factor_;
};

constexpr auto kAll = [](const PaperCoefficient&) { return true; };

void in_plane_step(PaperResult& result, const PaperTest& test, int index, int component) {
  static constexpr char kLower[] = "xyz";
  Step step(result, std::string("d") + kLower[component] + "_" + to_string(test.plane));
  step.choose([&](const PaperCoefficient& c) { return acts(c, test.plane, component); });
  const std::vector<double>& deviation = test.deviation[component == test.plane.first ? 0 : 1];
  for (std::size_t i = 0; i < deviation.size(); ++i)
    step.add(DesignRow(test, i), component, deviation[i], kAll);
  step.solve_for(Origin::measured, index);
}

/// (13) and (14): static and dynamic part of the deviation across every plane, each taken for zero.
void across_step(PaperResult& result, const std::vector<const PaperTest*>& tests, bool dynamic) {
  Step step(result, dynamic ? "(14)" : "(13)");
  step.choose([&](const PaperCoefficient& c) { return c.dynamic == dynamic && c.direction == c.axis + 3; });
  for (const PaperTest* test : tests) {
    const int across = 3 - test->plane.first - test->plane.second;
    for (std::size_t i = 0; i < test->angle.size(); ++i)
      step.add(DesignRow(*test, i), across, 0.0,
               [&](const PaperCoefficient& c) { return c.dynamic == dynamic; });
  }
  step.solve_for(Origin::assumed, -1);
}

DynamicShare share_of(const PaperResult& result, const PaperTest& test) {
  std::vector<double> statics, dynamics;
  for (std::size_t i = 0; i < test.angle.size(); ++i) {
    const DesignRow row(test, i);
    // dr = cos beta dx + sin beta dy
    std::array<double, 2> radial{};
    for (const PaperCoefficient& c : result.coefficients) {
      if (c.origin == Origin::missing) continue;
      radial[c.dynamic ? 1 : 0] += c.value * (std::cos(test.angle[i]) * row(c, test.plane.first) +
                                              std::sin(test.angle[i]) * row(c, test.plane.second));
    }
    statics.push_back(radial[0]);
    dynamics.push_back(radial[1]);
  }
  return dynamic_share(statics, dynamics);
}

PaperSine regression(std::span<const double> time, const std::vector<double>& values, PaperSine steady) {
  SineOptions options;
  options.omega_start = steady.omega;
  const auto fit = fit_sine(time, values, options);
  const auto* found = std::get_if<SineFit>(&fit);
  return found == nullptr ? steady : PaperSine{found->sine.omega, found->sine.phase};
}

/// Differences of second order on samples at any increasing times.
std::vector<double> rates(std::span<const double> time, const std::vector<double>& values) {
  std::vector<double> out(values.size(), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t a = i == 0 ? 0 : i - 1, b = std::min(i + 1, values.size() - 1);
    if (b > a) out[i] = (values[b] - values[a]) / (time[b] - time[a]);
  }
  return out;
}

}  // namespace

std::string PaperCoefficient::name() const {
  std::string out(1, "abcdefghijkl"[(dynamic ? 6 : 0) + direction]);
  out += '_';
  out += "xyz"[axis];
  return out + static_cast<char>('0' + order);
}

const PaperCoefficient* PaperResult::find(std::string_view name) const {
  const auto at = std::find_if(coefficients.begin(), coefficients.end(),
                               [&](const PaperCoefficient& c) { return c.name() == name; });
  return at == coefficients.end() ? nullptr : &*at;
}

DynamicShare dynamic_share(std::span<const double> statics, std::span<const double> dynamics) {
  double s1 = 0, d1 = 0, s2 = 0, d2 = 0;
  for (const double s : statics) s1 += std::abs(s), s2 += s * s;
  for (const double d : dynamics) d1 += std::abs(d), d2 += d * d;
  const auto part = [](double d, double s) { return d + s > 0 ? d / (d + s) : 0.0; };
  return {part(d1, s1), part(std::sqrt(d2), std::sqrt(s2)), part(d2, s2)};
}

PaperTest paper_test(const BallbarTest& test, const BallbarRun& run) {
  PaperTest out;
  out.plane = test.plane;
  out.radius = test.radius;
  out.angle = run.angle;
  out.time = run.time;
  const double omega = run.direction * test.feed / test.radius;
  if (out.time.empty())
    for (const double angle : run.angle) out.time.push_back((angle - run.angle.front()) / omega);
  const double start = run.angle.front() - omega * out.time.front();
  for (std::size_t k = 0; k < 2; ++k) {
    const int axis = k == 0 ? test.plane.first : test.plane.second;
    std::vector<double> position;
    for (std::size_t i = 0; i < run.angle.size(); ++i) {
      position.push_back(position_of(test, run, i)[axis]);
      // x = r (cos b - 1), y = r sin b from the start point; (7): dx = dr cos b, dy = dr sin b
      out.displacement[k].push_back(position.back() - test.centre[axis] - (k == 0 ? test.radius : 0.0));
      out.deviation[k].push_back(run.deviation[i] * radial_direction(test.plane, run.angle[i])[axis]);
    }
    // q = r cos(omega t + start - k pi/2): velocity and acceleration are sines of the same frequency
    const double lead = start - static_cast<double>(k) * std::numbers::pi / 2;
    out.velocity[k] = {omega, lead + std::numbers::pi};
    out.acceleration[k] = {omega, lead - std::numbers::pi / 2};
    if (run.actual.empty() || run.time.empty()) continue;
    const std::vector<double> velocity = rates(out.time, position);
    out.velocity[k] = regression(out.time, velocity, out.velocity[k]);
    out.acceleration[k] = regression(out.time, rates(out.time, velocity), out.acceleration[k]);
  }
  return out;
}

PaperResult identify_paper(const std::vector<PaperTest>& tests) {
  PaperResult result;
  result.coefficients = all_coefficients();
  std::vector<const PaperTest*> used;
  for (const TestPlane plane : {TestPlane{0, 1}, TestPlane{0, 2}, TestPlane{1, 2}}) {
    const auto at =
        std::find_if(tests.begin(), tests.end(), [&](const PaperTest& t) { return t.plane == plane; });
    if (at == tests.end()) continue;
    const int index = static_cast<int>(at - tests.begin());
    in_plane_step(result, *at, index, plane.second);
    in_plane_step(result, *at, index, plane.first);
    used.push_back(&*at);
  }
  if (used.size() == 3) {
    across_step(result, used, false);
    across_step(result, used, true);
    // The rotation about an axis' own direction goes with the sines of a test in which that axis moves.
    for (PaperCoefficient& c : result.coefficients)
      if (c.origin == Origin::assumed)
        c.test = static_cast<int>((c.axis == 2 ? used[1] : used[0]) - tests.data());
  }
  if (!result.finite)
    for (PaperCoefficient& c : result.coefficients) c.value = 0;
  for (const PaperTest& test : tests) result.shares.push_back(share_of(result, test));
  return result;
}

}  // namespace abbe
