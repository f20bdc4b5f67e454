#include "abbe/identify/joint_design.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

// Of a term with a smaller part of its effect along the bar only rounding or the noise of recorded positions
// is left there: scaled up, it would be taken for something seen.
constexpr double kAlongTheBar = 1e-3;
constexpr std::size_t kEnoughSamples = 90;  // of a run, evenly, to tell

bool share_setup(const BallbarTest& a, const BallbarTest& b) {
  return !a.setup.empty() && a.setup == b.setup;
}

std::string place_of(const BallbarTest& test) {
  return test.setup.empty() ? test.file : "set-up " + test.setup;
}

/// The group of test t: that of the first earlier test that shares it, else a new one.
template <class Shares>
std::size_t group_of(const std::vector<BallbarTest>& tests, std::size_t t, std::vector<std::size_t>& groups,
                     Shares shares) {
  for (std::size_t g = 0; g < groups.size(); ++g)
    if (share_setup(tests[groups[g]], tests[t]) && shares(tests[groups[g]], tests[t])) return g;
  groups.push_back(t);
  return groups.size() - 1;
}

}  // namespace

JointDesign::JointDesign(const Machine& machine, const std::vector<BallbarTest>& tests,
                         std::vector<ModelTerm> terms)
    : machine_(&machine),
      tests_(&tests),
      terms_(std::move(terms)),
      axes_(test_axes(machine)),
      effects_(machine, terms_) {
  for (std::size_t t = 0; t < tests.size(); ++t) {
    centre_.push_back(group_of(
        tests, t, centres_, [](const BallbarTest& a, const BallbarTest& b) { return a.plane == b.plane; }));
    bar_.push_back(group_of(tests, t, bars_,
                            [](const BallbarTest& a, const BallbarTest& b) { return a.radius == b.radius; }));
    std::vector<CircleMotion>& motions = motion_.emplace_back();
    for (const BallbarRun& run : tests[t].runs) motions.emplace_back(tests[t], run, axes_);
  }
  hide_terms();
}

void JointDesign::hide_terms() {
  std::vector<double> along(terms_.size()), whole(terms_.size());
  for (std::size_t t = 0; t < motion_.size(); ++t) {
    for (const CircleMotion& motion : motion_[t]) {
      for (std::size_t i = 0; i < motion.size(); i += motion.size() / kEnoughSamples + 1) {
        const AxisState state = motion.state(i);
        const Vec3 u = radial((*tests_)[t].plane, motion.bar_angle(i));
        for (std::size_t k = 0; k < terms_.size(); ++k) {
          const Vec3 effect = effects_.of(k, state) * basis(terms_[k], state);
          along[k] += u.dot(effect) * u.dot(effect);
          whole[k] += effect.squaredNorm();
        }
      }
    }
  }
  for (std::size_t k = 0; k < terms_.size(); ++k)
    hidden_.push_back(along[k] <= kAlongTheBar * kAlongTheBar * whole[k]);
}

std::vector<std::string> JointDesign::names() const {
  std::vector<std::string> names;
  for (const ModelTerm& term : terms_) names.push_back(to_string(term, *machine_));
  for (const std::size_t t : centres_) {
    const BallbarTest& test = (*tests_)[t];
    for (const int axis : {test.plane.first, test.plane.second})
      names.push_back(
          fmt::format("centre {} in {} ({})", axis_letter(axis), to_string(test.plane), place_of(test)));
  }
  for (const std::size_t t : bars_)
    names.push_back(fmt::format("bar length R{:g} ({})", (*tests_)[t].radius, place_of((*tests_)[t])));
  return names;
}

Vec3 JointDesign::radial(TestPlane plane, double angle) const {
  return std::cos(angle) * effects_.motion_of(axes_[static_cast<std::size_t>(plane.first)]) +
         std::sin(angle) * effects_.motion_of(axes_[static_cast<std::size_t>(plane.second)]);
}

void JointDesign::row(std::size_t test, std::size_t run, std::size_t i, double shift,
                      std::span<double> row) const {
  const CircleMotion& motion = motion_[test][run];
  const double angle = motion.bar_angle(i, shift);
  const AxisState state = motion.state(i, shift);
  const Vec3 u = radial((*tests_)[test].plane, angle);
  for (std::size_t k = 0; k < terms_.size(); ++k)
    row[k] = hidden_[k] ? 0.0 : u.dot(effects_.of(k, state)) * basis(terms_[k], state);
  std::fill(row.begin() + static_cast<std::ptrdiff_t>(terms_.size()), row.end(), 0.0);
  const std::size_t centre = terms_.size() + 2 * centre_[test];
  row[centre] = std::cos(angle);
  row[centre + 1] = std::sin(angle);
  row[first_bar() + bar_[test]] = 1;
}

double JointDesign::servo_part(std::size_t test, std::size_t run, std::size_t i) const {
  const BallbarRun& record = (*tests_)[test].runs[run];
  if (record.actual.empty() || record.commanded.empty()) return 0;
  // Exact: with a lag along the path of tenths of a mm the first order is not enough.
  const Vec3& centre = (*tests_)[test].centre;
  return (record.actual[i] - centre).norm() - (record.commanded[i] - centre).norm();
}

std::vector<int> moving_axes(const Machine& machine, const std::vector<BallbarTest>& tests) {
  const TestAxes axes = test_axes(machine);
  std::vector<int> moving;
  for (const BallbarTest& test : tests) {
    for (const int k : {test.plane.first, test.plane.second}) {
      const int axis = axes[static_cast<std::size_t>(k)];
      if (axis < 0) return {};
      moving.push_back(axis);
    }
  }
  std::sort(moving.begin(), moving.end());
  moving.erase(std::unique(moving.begin(), moving.end()), moving.end());
  return moving;
}

std::vector<Travel> travel_of_tests(const Machine& machine, const std::vector<BallbarTest>& tests) {
  std::vector<Travel> travel(static_cast<std::size_t>(machine.axis_count()), Travel{0, 0});
  std::vector<bool> seen(travel.size());
  const TestAxes axes = test_axes(machine);
  for (const BallbarTest& test : tests) {
    for (const int k : {test.plane.first, test.plane.second}) {
      if (axes[static_cast<std::size_t>(k)] < 0) continue;
      const auto axis = static_cast<std::size_t>(axes[static_cast<std::size_t>(k)]);
      const Travel here = {test.centre[k] - test.radius, test.centre[k] + test.radius};
      travel[axis] =
          seen[axis] ? Travel{std::min(travel[axis][0], here[0]), std::max(travel[axis][1], here[1])} : here;
      seen[axis] = true;
    }
  }
  return travel;
}

}  // namespace abbe
