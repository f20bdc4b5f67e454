#include "abbe/identify/nodal_spline.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "abbe/errors/spline.h"
#include "abbe/identify/errors_file.h"
#include "abbe/identify/joint.h"
#include "abbe/identify/test_circles.h"

namespace abbe {
namespace {

constexpr std::array<double, 2> kTravel = {-40, 160};
constexpr int kNodes = 7;

TEST(NodalSpline, NodalSplinesHaveNoTrend) {
  for (int node = 0; node < kNodes; ++node) {
    const NodalSpline f(kTravel, kNodes, node);
    EXPECT_NEAR(f(60), 0, 1e-12);
    double moment = 0, size = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double q = -40 + 200 * (i + 0.5) / kSteps;
      moment += f(q) * (q - 60);
      size += std::abs(f(q) * (q - 60));
    }
    EXPECT_LT(std::abs(moment), 1e-6 * size) << node;
    EXPECT_EQ(f(170), f(160));
    EXPECT_EQ(f(-100), f(-40));
  }
}

// Any values at the nodes: the inner splines, a constant and a line give the natural spline through them.
TEST(NodalSpline, NodalSplinesAndALineAreAllNaturalSplines) {
  const std::vector<double> wanted = {3, -1, 4, 1, -5, 9, 2};
  std::vector<NodalSpline> splines;
  for (int node = 1; node + 1 < kNodes; ++node) splines.emplace_back(kTravel, kNodes, node);
  const std::vector<double> nodes = splines[0].nodes();
  const auto row = [&](double q) {
    Eigen::RowVectorXd r(kNodes);
    r[0] = 1;
    r[1] = q;
    for (int k = 2; k < kNodes; ++k) r[k] = splines[static_cast<std::size_t>(k - 2)](q);
    return r;
  };
  Eigen::MatrixXd at_nodes(kNodes, kNodes);
  for (int i = 0; i < kNodes; ++i) at_nodes.row(i) = row(nodes[static_cast<std::size_t>(i)]);
  const Eigen::VectorXd c =
      at_nodes.fullPivLu().solve(Eigen::Map<const Eigen::VectorXd>(wanted.data(), kNodes));
  const std::vector<double> M = natural_spline(nodes, wanted);
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    const double h = nodes[k + 1] - nodes[k], a = 0.3, b = 0.7;
    const double spline =
        a * wanted[k] + b * wanted[k + 1] + h * h / 6 * ((a * a * a - a) * M[k] + (b * b * b - b) * M[k + 1]);
    EXPECT_NEAR(row(nodes[k] + b * h).dot(c), spline, 1e-9);
  }
}

// Errors that no polynomial of low order follows: found from two radii, they predict a third one, and the
// errors file says the same.
TEST(NodalSpline, JointIdentificationFollowsASpline) {
  const std::string text = "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n";
  const Machine hidden = test::machine_of(text + R"([errors]
EXX = { table = [[-150, 2], [-100, -4], [-50, 3], [0, 0], [50, 5], [100, -6], [150, 1]], interpolation = "cubic" }
EYX = { table = [[-150, -1], [-100, 3], [-50, -2], [0, 0], [50, 4], [100, -3], [150, 2]], interpolation = "cubic" }
)");
  std::vector<BallbarTest> tests;
  unsigned seed = 1;
  for (const double radius : {80.0, 120.0, 150.0})
    for (const double feed : {10.0, 40.0})
      tests.push_back(test::measured(hidden, {{0, 1}, radius, feed, 360, 0, 360, "one"}, 0.01 * um, seed++));
  IdentifyOptions options;
  options.terms.rotation = 0;
  options.terms.positioning = options.terms.straightness = 3;
  const Machine bare = test::machine_of(text);
  const auto rms_at_another_radius = [&](const Identification& found) {
    const BallbarTest unseen = test::measured(hidden, {{0, 1}, 135, 25, 100});
    const TracePrediction trace = predict_trace(bare, found, unseen, 0);
    TriangularFactor factor(3);
    for (std::size_t i = 0; i < trace.deviation.size(); ++i)
      factor.add(std::array{1.0, std::cos(unseen.runs[0].angle[i]), std::sin(unseen.runs[0].angle[i])},
                 unseen.runs[0].deviation[i] - trace.deviation[i]);
    return std::sqrt(solve(factor, {}).sum_of_squares / static_cast<double>(trace.deviation.size()));
  };
  const Identification powers = identify_jointly(bare, tests, options);
  ASSERT_TRUE(powers.ok());
  EXPECT_FALSE(powers.trusted) << "cubics do not follow these errors";
  options.terms.splines = 7;
  const Identification found = identify_jointly(bare, tests, options);
  ASSERT_TRUE(found.ok());
  EXPECT_LT(rms_at_another_radius(found), 0.1 * rms_at_another_radius(powers));
  EXPECT_LT(rms_at_another_radius(found), 0.05 * um);

  const std::string file = errors_file_of(bare, found, tests, {});
  const auto read =
      read_machine({"machine.toml", text}, MachineText{"errors.toml", file},
                   [](const std::string&) -> std::optional<std::string> { return std::nullopt; });
  ASSERT_TRUE(read.value) << file;
  for (const ErrorTerm& error : read.value->errors) {
    const std::string name = to_string(error.name);
    if (name != "EXX" && name != "EYX") continue;
    for (const double x : {-140.0, -73.0, 20.0, 111.0}) {
      double sum = 0;
      AxisState state;
      state.q[0] = x;
      for (const IdentifiedTerm& term : found.terms)
        if (to_string(term.term.name) == name && !term.term.is_dynamic() &&
            term.term.form != ModelTerm::Form::lost_motion)
          sum += term.value * basis(term.term, state);
      const std::array<double, 3> variables = {x, 0, 0};
      const std::array<signed char, 3> approach{};
      bool outside = false;
      EXPECT_NEAR(error.function.value<double>(variables.data(), approach.data(), &outside) * um, sum,
                  1e-6 * um)
          << name;
    }
  }
}

}  // namespace
}  // namespace abbe
