#pragma once

#include <span>
#include <string>
#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/identify/circle_motion.h"
#include "abbe/identify/error_effects.h"
#include "abbe/identify/model_term.h"

namespace abbe {

/// The rows of a joint identification: one per sample of every run of every test.
///
///     dR = u . sum_i effect_i(q) basis_i(q, v, a) c_i + c_a cos t + c_b sin t + dR_0        (u nominal)
///
/// Unknowns: the coefficients of the terms, then two coordinates of every centre, then the length error of
/// every bar. Tests of one set-up (the balls stay where they are) share the centre in each plane, and the bar
/// of each radius. u and the plane follow the nominal motion of the tip, so a machine whose axis runs the
/// other way is described by its file, not by special cases here. A term of whose effect less than a
/// thousandth lies along the bar, over all samples, is not seen: its column is zero.
class JointDesign {
 public:
  JointDesign(const Machine& machine, const std::vector<BallbarTest>& tests, std::vector<ModelTerm> terms);

  [[nodiscard]] const std::vector<ModelTerm>& terms() const { return terms_; }
  [[nodiscard]] std::size_t unknowns() const { return first_bar() + bars_.size(); }
  /// Index of the first bar length.
  [[nodiscard]] std::size_t first_bar() const { return terms_.size() + 2 * centres_.size(); }
  /// "EXX X^2", "centre X in XY (file)", "bar R100 (file)", .. per unknown.
  [[nodiscard]] std::vector<std::string> names() const;

  /// Factors of all unknowns at sample i of a run, `shift` seconds later. row: unknowns()
  void row(std::size_t test, std::size_t run, std::size_t i, double shift, std::span<double> row) const;
  /// |actual - centre| - |commanded - centre| where both were recorded, else 0: what the servo itself sees.
  [[nodiscard]] double servo_part(std::size_t test, std::size_t run, std::size_t i) const;

  [[nodiscard]] const CircleMotion& motion(std::size_t test, std::size_t run) const {
    return motion_[test][run];
  }
  [[nodiscard]] const std::vector<BallbarTest>& tests() const { return *tests_; }

 private:
  void hide_terms();
  [[nodiscard]] Vec3 radial(TestPlane plane, double angle) const;

  const Machine* machine_;
  const std::vector<BallbarTest>* tests_;
  std::vector<ModelTerm> terms_;
  TestAxes axes_;
  ErrorEffects effects_;
  std::vector<std::vector<CircleMotion>> motion_;  ///< per test and run
  std::vector<std::size_t> centres_, bars_;        ///< the first test of each
  std::vector<std::size_t> centre_, bar_;          ///< per test
  std::vector<bool> hidden_;                       ///< per term
};

/// Indices of the machine's linear axes that take part in the tests, along the chain; empty if an axis of a
/// test is missing or is no linear axis.
[[nodiscard]] std::vector<int> moving_axes(const Machine& machine, const std::vector<BallbarTest>& tests);

/// What the nominal circles of the tests cover of every moving axis of the machine; {0, 0} where nothing
/// moves.
[[nodiscard]] std::vector<Travel> travel_of_tests(const Machine& machine,
                                                  const std::vector<BallbarTest>& tests);

}  // namespace abbe
