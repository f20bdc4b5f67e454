#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/ballbar/trace.h"

namespace abbe {

/// sin(omega t + phase): what velocity and acceleration of an axis look like during one test.
struct PaperSine {
  double omega = 0, phase = 0;  ///< rad/s, rad
};

/// One circular test as the published method sees it: displacements from the start point, where the tool ball
/// is at radius along the first axis, and the components of the deviation in the plane.
struct PaperTest {
  TestPlane plane;                                  ///< XY, XZ or YZ
  double radius = 0;                                ///< mm
  std::vector<double> angle;                        ///< beta, rad
  std::vector<double> time;                         ///< s
  std::array<std::vector<double>, 2> displacement;  ///< of the first and second axis, mm
  std::array<std::vector<double>, 2> deviation;     ///< component along them, mm
  std::array<PaperSine, 2> velocity, acceleration;  ///< of the first and second axis
};

/// The test of a run: displacements from the nominal circle, components by (7): the radial deviation
/// projected on both axes, which takes the deviation along the path for zero. The sines are those of a
/// steady circle; a run with times and recorded positions gets them by regression.
///
/// errors   the samples of runs without time are timed by the feed
[[nodiscard]] PaperTest paper_test(const BallbarTest& test, const BallbarRun& run);

/// One of the 72 coefficients of the 36 error elements: b_x1 is of delta_yx, l_y2 of epsilon_zy.
///
/// letters   a b c = displacement along X Y Z, d e f = rotation about X Y Z (static);  g h i, j k l (dynamic)
/// static    positioning a_x, b_y, c_z: c0 + c1 q;  the others: c1 q + c2 q^2, q the displacement of the axis
/// dynamic   c1 sin(omega_v t + phi_v) + c2 sin(omega_a t + phi_a)
struct PaperCoefficient {
  enum class Origin {
    measured,  ///< the test determines it
    artefact,  ///< the test determines only a sum; this share of it is the choice of least norm
    assumed,   ///< follows from the assumption that nothing happens across the plane, which nothing measures
    missing,   ///< its plane was not tested
  } origin = Origin::missing;
  bool dynamic = false;
  int direction = 0;  ///< 0..5: X Y Z A B C
  int axis = 0;       ///< 0..2: X Y Z
  int order = 0;      ///< 0, 1 or 2
  double value = 0;   ///< mm or rad per mm^order
  int test = -1;      ///< index of the test whose sines it goes with

  [[nodiscard]] std::string name() const;
};

struct PaperStep {
  std::string equation;  ///< "dy_XY", "(13)"
  Eigen::Index unknowns = 0, rank = 0;
  double rms_residual = 0;  ///< mm
};

/// Part of the dynamic terms in the radial deviation, over the samples of a test:
///     L1      sum |d| / (sum |d| + sum |s|)
///     rms     |d|_2 / (|d|_2 + |s|_2)
///     energy  |d|_2^2 / (|d|_2^2 + |s|_2^2)
struct DynamicShare {
  double l1 = 0, rms = 0, energy = 0;
};
[[nodiscard]] DynamicShare dynamic_share(std::span<const double> statics, std::span<const double> dynamics);

struct PaperResult {
  std::vector<PaperCoefficient> coefficients;  ///< 72: static a..f of X Y Z, then dynamic g..l
  std::vector<PaperStep> steps;
  std::vector<DynamicShare> shares;  ///< per test
  bool finite = true;                ///< false: numbers that are too large; every value is then 0

  [[nodiscard]] const PaperCoefficient* find(std::string_view name) const;
};

/// Identification exactly as published: per plane a least-norm least squares for the component along the
/// second axis, then for the first, with what is known carried on (XY, XZ, YZ), and at last the six rotations
/// about the axes' own directions by the assumption that the deviation across each plane is zero.
///
/// tests    at most one per plane XY, XZ, YZ, in any order; each with equally long vectors
/// errors   finite = false; steps of planes that are missing are left out
/// laws     EqualsTheFiftyDigitNumbers, SeparatesSumsByTheRatioOfTheRadius
/// source   seed 004 with the misprints of docs/errata.md corrected; docs/theory/identification.md, section 2
[[nodiscard]] PaperResult identify_paper(const std::vector<PaperTest>& tests);

}  // namespace abbe
